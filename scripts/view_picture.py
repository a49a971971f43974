#!/usr/bin/env python3
"""The picture of the viewer in README.md: docs/images/view.webp, by a headless Chromium.
usage: scripts/view_picture.py TYNDALL OUT.webp [SCENE METHOD SPP]"""
import base64, os, signal, subprocess, sys, tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
import chromium
from chromium import Browser

STATE = "window.tyndall.state"


def take(address, spp):
    with Browser(1280, 760, dark=True, webgl=True) as browser:
        browser.open(address)
        browser.wait_for(f"window.tyndall && {STATE}.frames[0] && {STATE}.frames[0].final")
        browser.call("Input.dispatchKeyEvent", type="keyDown", key="w", code="KeyW", text="w")
        chromium.WAIT = 300  # path converges
        browser.wait_for(f"{STATE}.status.path.spp >= {spp} && {STATE}.status.difference")
        return base64.b64decode(browser.call("Page.captureScreenshot", format="webp", quality=60)["data"])


def main(tyndall, out, scene="builtin:cloud_sun", method="dom", spp="32"):
    out = os.path.abspath(out)
    viewer = subprocess.Popen([os.path.abspath(tyndall), "view", scene, "--no-open", "-q", "--method", method, "--size", "640x400"],
                              stdout=subprocess.PIPE, text=True)
    try:
        address = viewer.stdout.readline().strip()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            picture = take(address, float(spp))
            os.chdir("/")
    finally:
        viewer.send_signal(signal.SIGINT)
        viewer.wait()
    with open(out, "wb") as file:
        file.write(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
