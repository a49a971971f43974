#!/usr/bin/env python3
"""The animated picture of the viewer in README.md: docs/images/view.webp, by a headless Chromium and img2webp (Debian's package
webp). The camera orbits, the first light turns, the density rises, and each time path converges beside the method.
usage: scripts/view_picture.py TYNDALL OUT.webp [SCENE METHOD SPP]"""
import base64, math, os, signal, subprocess, sys, tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
import chromium
from chromium import Browser

STATE = "window.tyndall.state"
WIDTH, HEIGHT = 1120, 640
MOVING, SETTLED, SHOWN = 110, 450, 1800  # ms of a frame of the animation
QUALITY = "68"  # below, parts of a frame stay those of the one before
ORBIT_STEPS, LIGHT_STEPS, DENSITY_STEPS = 9, 9, 6


class Film:
    def __init__(self, browser):
        self.browser, self.frames = browser, []

    def take(self, milliseconds):
        name = f"frame{len(self.frames):03d}.png"
        with open(name, "wb") as file:
            file.write(base64.b64decode(self.browser.call("Page.captureScreenshot", format="png")["data"]))
        self.frames.append((name, milliseconds))

    def settle(self, spp):
        """The final image, and path from its first samples to the last."""
        self.browser.wait_for(f"{STATE}.frames[0].final && {STATE}.frames[0].revision === {STATE}.status.revision")
        for part in (0.02, 0.2):
            self.browser.wait_for(f"{STATE}.status.path.spp >= {part * spp} && {STATE}.status.difference")
            self.take(SETTLED)
        self.browser.wait_for(f"{STATE}.status.path.spp >= {spp} && {STATE}.status.difference")
        self.take(SHOWN)

    def after(self, change):
        """One frame of a change that goes on, once an image answers it."""
        before = self.browser.run(f"{STATE}.frames[0].revision")
        change()
        self.browser.wait_for(f"{STATE}.frames[0].revision > {before}")
        self.take(MOVING)

    def write(self, out):
        options = [text for name, time in self.frames for text in ("-d", str(time), name)]
        subprocess.run(["img2webp", "-loop", "0", "-lossy", "-q", QUALITY, "-m", "6", *options, "-o", out], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def mouse(browser, kind, x, y):
    browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=0 if kind == "mouseReleased" else 1,
                 clickCount=1)


def orbit(film):
    x, y = 0.35 * WIDTH, 0.4 * HEIGHT
    mouse(film.browser, "mousePressed", x, y)
    for step in range(1, ORBIT_STEPS + 1):
        film.after(lambda: mouse(film.browser, "mouseMoved", x + 9 * step, y + 2 * step))
    mouse(film.browser, "mouseReleased", x + 9 * ORBIT_STEPS, y + 2 * ORBIT_STEPS)
    mouse(film.browser, "mouseMoved", x, 2)  # off the image, where the probe shows nothing


class Editor:
    """A second client, which changes the scene while the page looks on."""

    def __init__(self, browser):
        self.browser = browser
        browser.run("new Promise(done => { const socket = new WebSocket(location.href.replace('http', 'ws').replace('/?', '/live?'));"
                    " socket.onopen = done; socket.binaryType = 'arraybuffer'; socket.onmessage = ({data}) => { if (typeof data === 'string')"
                    " return; const view = new DataView(data); socket.send(JSON.stringify({type: 'ack', channel: view.getUint8(4),"
                    " sequence: view.getUint32(8, true)})); }; window.editor = socket; }).then(() => 0)")

    def set(self, path, value, moving):
        self.browser.run("window.editor.send(JSON.stringify({type: 'set', id: 1, moving: %s, changes: [{path: '%s', value: %s}]}))"
                         % (str(moving).lower(), path, value))


def turned(direction, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = direction
    return [round(c * x + s * z, 4), y, round(c * z - s * x, 4)]


def record(address, spp, out):
    with Browser(WIDTH, HEIGHT, dark=True, webgl=True) as browser:
        browser.open(address)
        browser.wait_for(f"window.tyndall && {STATE}.frames[0] && {STATE}.frames[0].final")
        browser.call("Input.dispatchKeyEvent", type="keyDown", key="w", code="KeyW", text="w")
        chromium.WAIT = 300  # path converges
        film, editor = Film(browser), Editor(browser)
        film.settle(spp)
        orbit(film)
        film.settle(spp)
        direction = browser.run(f"{STATE}.document.lights[0].direction")
        for step in range(1, LIGHT_STEPS + 1):
            film.after(lambda: editor.set("lights[0].direction", turned(direction, 12 * step), step < LIGHT_STEPS))
        film.settle(spp)
        for step in range(1, DENSITY_STEPS + 1):
            film.after(lambda: editor.set("media[0].scale", round(0.75 ** step, 4), step < DENSITY_STEPS))
        film.settle(spp)
        film.write(out)


def main(tyndall, out, scene="builtin:cloud_sun", method="dom", spp="32"):
    out = os.path.abspath(out)
    viewer = subprocess.Popen([os.path.abspath(tyndall), "view", scene, "--no-open", "-q", "--method", method, "--size", "640x400"],
                              stdout=subprocess.PIPE, text=True)
    try:
        address = viewer.stdout.readline().strip()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            record(address, float(spp), out)
            os.chdir("/")
    finally:
        viewer.send_signal(signal.SIGINT)
        viewer.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
