#!/usr/bin/env python3
"""The viewer's page in a headless browser: image, probe, wipe, controls, undo, camera, keys; no errors, no request elsewhere.
usage: test_view_page.py ADDRESS, as `tyndall view` prints it; the scene has media, and none of the methods needs long."""
import base64, json, os, re, sys, tempfile
from urllib.parse import urlsplit

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Browser, find_browser

STATE = "window.tyndall.state"


def press(browser, key, code=None, control=False, shift=False):
    modifiers = (2 if control else 0) + (8 if shift else 0)
    event = {"key": key, "code": code or key, "modifiers": modifiers,
             "windowsVirtualKeyCode": {"Escape": 27, "Home": 36, "ArrowUp": 38}.get(key, ord(key[0].upper()))}
    browser.call("Input.dispatchKeyEvent", type="keyDown" if len(key) == 1 and not control else "rawKeyDown",
                 **event, **({"text": key} if len(key) == 1 and not control else {}))
    browser.call("Input.dispatchKeyEvent", type="keyUp", **event)


def drag(browser, start, end, button="left"):
    browser.mouse("mousePressed", *start, button=button, buttons=1, clickCount=1)
    for i in range(1, 9):
        browser.mouse("mouseMoved", *(a + (b - a) * i / 8 for a, b in zip(start, end)), button=button, buttons=1)
    browser.mouse("mouseReleased", *end, button=button, buttons=0, clickCount=1)


def picture(browser):
    return base64.b64decode(browser.call("Page.captureScreenshot", format="png")["data"])


def box_of(browser, selector):
    return browser.run(f"(b => [b.x, b.y, b.width, b.height])(document.querySelector({json.dumps(selector)}).getBoundingClientRect())")


def wait_final(browser, revision=0):
    browser.wait_for(f"(f => f && f.final && f.revision >= {revision})({STATE}.frames[0])")


def check_image(browser):
    browser.wait_for(f"window.tyndall && {STATE}.connection === 'open'")
    wait_final(browser)
    frame = browser.run(f"{STATE}.frames[0]")
    assert frame["width"] == frame["fullWidth"] > 0 and frame["height"] == frame["fullHeight"] > 0, frame
    found = browser.run(f"window.tyndall.probe({frame['width'] // 2}, {frame['height'] // 2}, 0)")
    assert found["exact"], found
    mean = 0.2126 * found["r"] + 0.7152 * found["g"] + 0.0722 * found["b"]
    assert abs(found["luminance"] - mean) <= 1e-6 * (1 + mean), found
    assert browser.run(f"window.tyndall.probe(-1, 0, 0) === null && window.tyndall.probe({frame['width']}, 0, 0) === null")


def check_display(browser):
    """Keys change the picture, and nothing of it goes through the server."""
    revision, before = browser.run(f"{STATE}.frames[0].revision"), picture(browser)
    for key, back in (("]", "["), ("v", "v"), ("r", "r"), ("k", "k")):
        press(browser, key)
        browser.wait_for("new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(() => resolve(true))))")
        assert picture(browser) != before, key
        for _ in range(3 if key == "k" else 1):
            press(browser, back)
    assert browser.run(f"{STATE}.frames[0].revision") == revision
    press(browser, "?")
    assert browser.run("document.querySelector('#keys').open")
    press(browser, "Escape")
    assert not browser.run("document.querySelector('#keys').open")


def check_wipe(browser):
    press(browser, "w")
    browser.wait_for(f"{STATE}.display.mode === 'wipe' && {STATE}.frames[1] !== null")
    x, y, width, height = box_of(browser, "#divider")
    stage = box_of(browser, "#screen")
    drag(browser, (x + width / 2, y + height / 3), (stage[0] + stage[2] / 4, y + height / 3))
    assert browser.run(f"{STATE}.display.wipe") < 0.5
    press(browser, "d")
    assert not browser.run("document.querySelector('#legend').hidden")
    press(browser, "m")


def check_pin(browser):
    x, y, width, height = box_of(browser, "#screen")
    for kind in ("mousePressed", "mouseReleased"):
        browser.mouse(kind, x + width / 2, y + height / 2, button="left", buttons=1, clickCount=1, modifiers=8)
    assert re.search(r"pinned", browser.run("document.querySelector('#probe').textContent"))
    press(browser, "Escape")


def check_edit(browser):
    """One step of a number goes to the server and comes back by undo."""
    row = browser.run("[...document.querySelectorAll('[data-path^=\"media[0]\"]')]"
                      ".find(r => r.querySelector('input[inputmode=decimal]')).dataset.path")
    value = f"JSON.stringify(document.querySelector('[data-path=\"{row}\"] input[inputmode=decimal]').value)"
    revision, before = browser.run(f"{STATE}.frames[0].revision"), browser.run(value)
    browser.run(f"document.querySelector('[data-path=\"{row}\"] input[inputmode=decimal]').focus()")
    press(browser, "ArrowUp")
    press(browser, "Escape")
    assert browser.run(value) != before, row
    wait_final(browser, revision + 1)
    assert browser.run(f"document.querySelector('[data-path=\"{row}\"]').classList.contains('changed')")
    press(browser, "z", "KeyZ", control=True)
    browser.wait_for(f"{value} === {json.dumps(before)}")
    wait_final(browser, revision + 2)


def check_camera(browser):
    at, revision = browser.run(f"{STATE}.camera.position"), browser.run(f"{STATE}.frames[0].revision")
    x, y, width, height = box_of(browser, "#screen")
    drag(browser, (x + width / 2, y + height / 2), (x + width / 2 + 60, y + height / 2 + 10))
    assert browser.run(f"{STATE}.camera.position") != at
    browser.wait_for(f"{STATE}.frames[0].revision > {revision}")
    press(browser, "Home")
    back = browser.run(f"{STATE}.camera.position")
    assert all(abs(a - b) <= 1e-6 * max(1, abs(a)) for a, b in zip(at, back)), (at, back)
    wait_final(browser, revision + 2)


def main(address):
    if find_browser() is None:
        print("there is no Chromium")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with Browser(1280, 800, dark=True, webgl=True) as browser:
            browser.open(address)
            for check in (check_image, check_display, check_wipe, check_pin, check_edit, check_camera):
                check(browser)
            own = urlsplit(address).netloc
            elsewhere = [url for url in browser.requests if urlsplit(url).scheme != "blob" and urlsplit(url).netloc != own]
            assert not elsewhere, elsewhere
            assert not browser.errors, browser.errors
        os.chdir("/")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
