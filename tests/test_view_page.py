#!/usr/bin/env python3
"""The viewer's page in a headless browser: image, probe, wipe, controls, undo, camera, keys; no errors, no request elsewhere.
usage: test_view_page.py ADDRESS, as `tyndall view` prints it; the scene has media, and none of the methods needs long."""
import base64, json, os, re, sys, tempfile, time
from urllib.parse import urlsplit

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Browser, WAIT, find_browser

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


def check_method(browser):
    """A digit's key switches the method, and another one switches back."""
    first, names = browser.run(f"{STATE}.view.chosen"), browser.run(f"{STATE}.welcome.methods.map(m => m.name)")
    for name in ("octaves", first):
        press(browser, str(names.index(name) + 1))
        browser.wait_for(f"{STATE}.view.chosen === {json.dumps(name)} && {STATE}.status.method === {json.dumps(name)} && {STATE}.status.final")
        wait_final(browser)


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


# ---- frames of a sequence ----

FRAME = f"{STATE}.document.frame"


def type_into(browser, selector, text):
    """Into a number field, which takes it when it loses the focus."""
    browser.run(f"(e => {{ e.focus(); e.value = {json.dumps(text)}; e.dispatchEvent(new Event('input'));"
                f" e.dispatchEvent(new Event('change')); e.blur(); }})({selector})")


def button(browser, text):
    browser.run(f"[...document.querySelectorAll('button')].find(b => b.textContent === {json.dumps(text)}).click()")


def check_sequence(browser, folder, last):
    """Play shows one frame after the other, at most 24 a second, and begins anew; Record all writes each as the final image."""
    check_image(browser)
    assert not browser.run("document.querySelector('#frames').hidden")
    type_into(browser, "document.querySelectorAll('#frames .body input[inputmode=decimal]')[2]", str(last))
    browser.run("window.frames_seen = []; setInterval(() => { const f = window.tyndall.state.document.frame ?? 0;"
                " if (window.frames_seen.at(-1) !== f) window.frames_seen.push(f); }, 5); true")
    button(browser, "Play")
    browser.wait_for(f"window.frames_seen.length > {2 * last + 3}")
    button(browser, "Stop")
    browser.wait_for("[...document.querySelectorAll('button')].some(b => b.textContent === 'Play')")
    seen = browser.run("window.frames_seen")
    assert all(b == (a + 1) % (last + 1) for a, b in zip(seen, seen[1:])), seen
    at = browser.run(FRAME)
    wait_final(browser)
    press(browser, ".")
    browser.wait_for(f"{FRAME} === {at + 1}")
    press(browser, ",")
    browser.wait_for(f"{FRAME} === {at}")
    type_into(browser, "document.querySelector('#record-name')", "take.exr")
    button(browser, "Record all")
    names = [f"take_{frame:04}.exr" for frame in range(last + 1)]
    browser.wait_for("[...document.querySelectorAll('button')].some(b => b.textContent === 'Stop')")
    browser.wait_for("[...document.querySelectorAll('button')].some(b => b.textContent === 'Play')")
    assert sorted(name for name in os.listdir(folder) if name.startswith("take")) == names, os.listdir(folder)
    assert not browser.run("document.querySelector('#troubles').textContent")


# ---- JPEG while something moves ----

def wait_rest(browser, center):
    """Until the image is exact, final, and that of the last change."""
    seen, since, deadline = None, 0, time.monotonic() + WAIT
    while time.monotonic() < deadline:
        frame = browser.run(f"(f => [f.revision, f.final, {center}.exact])({STATE}.frames[0])")
        if frame != seen:
            seen, since = frame, time.monotonic()
        if frame[1:] == [True, True] and time.monotonic() - since > 2:
            return
        time.sleep(0.05)
    raise AssertionError(("no rest", seen))


def check_remote(browser, row):
    """While a number is dragged images are JPEG, at rest exact, and both show the same."""
    check_image(browser)
    center = f"(f => window.tyndall.probe(f.fullWidth >> 1, f.fullHeight >> 1))({STATE}.frames[0])"
    press(browser, "]")  # JPEGs are made with the exposure of the page
    browser.wait_for(f"{STATE}.view.exposure > 0.3")
    slider = f"document.querySelector('[data-path=\"{row}\"] input[type=range]')"
    exact = browser.run(center)["luminance"]
    revision = browser.run(f"{STATE}.frames[0].revision")
    move = f"(s => {{ s.value = Number(s.value) + 0.001; s.dispatchEvent(new Event('input')); }})({slider})"
    browser.run(f"window.moving = setInterval(() => {move}, 30); true")
    moved = browser.wait_for(f"((frame, found) => frame.revision > {revision + 3} && !found.exact && {{frame, found}})({STATE}.frames[0], {center})")
    frame, found = moved["frame"], moved["found"]
    assert not frame["final"] and frame["exposure"] > 0.3, frame
    assert 0.5 < found["luminance"] / exact < 2, (found, exact)
    browser.run("clearInterval(window.moving); true")
    wait_rest(browser, center)  # without the drag's end, too
    rest = browser.run(center)["luminance"]
    browser.run(f"{slider}.dispatchEvent(new Event('change')); true")
    wait_rest(browser, center)
    assert 0.5 < rest / exact < 2 and browser.run(center)["luminance"] == rest, (rest, exact)
    if browser.run(f"{STATE}.welcome.kind") == "scene":  # the camera moves in the same way
        x, y, width, height = box_of(browser, "#screen")
        browser.mouse("mousePressed", x + width / 2, y + height / 2, button="left", buttons=1, clickCount=1)
        for i in range(1, 6):
            browser.mouse("mouseMoved", x + width / 2 + 6 * i, y + height / 2, button="left", buttons=1)
        browser.wait_for(f"!{center}.exact || {STATE}.frames[0].final")
        browser.mouse("mouseReleased", x + width / 2 + 30, y + height / 2, button="left", buttons=0, clickCount=1)
        browser.wait_for(f"{center}.exact && {STATE}.frames[0].final")


# ---- a photograph ----

def check_photo(browser):
    """Before and after in the place of path, options in panels, no camera, and what is kept is the medium and a command."""
    check_image(browser)
    hidden = lambda selector: browser.run(f"document.querySelector({json.dumps(selector)}).closest('[hidden]') !== null")
    assert hidden("#methods") and hidden("#compare") and hidden("#size") and not hidden("#modes")
    browser.wait_for(f"{STATE}.frames[1] !== null")
    press(browser, "w")
    browser.wait_for("document.querySelector('#side-right').textContent === 'photograph'")
    assert not browser.run("document.querySelector('#divider').hidden")
    assert browser.run(f"{STATE}.view.compare") is False
    press(browser, "m")
    through = lambda: browser.run(f"(f => window.tyndall.probe(f.fullWidth >> 1, f.fullHeight >> 1, 0).luminance)({STATE}.frames[0])")
    before = through()
    for key in ("ArrowUp", "+", "Home", "o", "1", "c", "."):  # there is no camera, no other method, no frame
        press(browser, key)
    x, y, width, height = box_of(browser, "#screen")
    drag(browser, (x + width / 2, y + height / 2), (x + width / 2 + 60, y + height / 2))
    assert "no camera" in browser.run("document.querySelector('#notice').textContent")
    assert browser.run(f"{STATE}.camera === null && {STATE}.frames[0].revision === 1") and through() == before
    row = lambda path: f"document.querySelector('[data-path=\"{path}\"]')"
    type_into(browser, row("medium.visibility") + ".querySelector('input[inputmode=decimal]')", "2")
    wait_final(browser, 2)
    assert through() != before
    assert browser.run(row("spread") + " !== null") and browser.run(row("mask-width") + " === null")
    browser.run(f"(s => {{ s.value = 'gather'; s.dispatchEvent(new Event('change')); }})({row('variant')}.querySelector('select'))")
    wait_final(browser, 3)
    assert browser.run(row("spread") + " === null") and browser.run(row("mask-width") + " !== null")
    press(browser, "z", "KeyZ", control=True)
    press(browser, "z", "KeyZ", control=True)
    wait_final(browser, 5)
    assert through() == before and not browser.run("document.querySelector('.row.changed') !== null")
    assert browser.run("document.querySelector('#save').textContent") == "Save medium"
    assert not browser.run("document.querySelector('#troubles').textContent")
    press(browser, "?")
    assert not re.search("path|orbit|camera", browser.run("document.querySelector('#keys').textContent"))
    press(browser, "Escape")


# ---- keeping, and a lost connection ----

def check_kept(browser, kept):
    """The probe of all pixels, and the file that Save gives: to kept."""
    check_image(browser)
    frame = browser.run(f"{STATE}.frames[0]")
    kept["size"] = width, height = frame["fullWidth"], frame["fullHeight"]
    kept["pixels"] = browser.run(f"Array.from({{length: {width * height}}}, (_, i) => window.tyndall.probe(i % {width}, Math.floor(i / {width}), 0))"
                                 ".flatMap(p => [p.r, p.g, p.b])")
    browser.run("(make => { URL.createObjectURL = blob => { window.blob = blob; return make(blob); }; })"
                "(URL.createObjectURL.bind(URL)); document.querySelector('#save').click(); true")
    browser.wait_for("window.blob !== undefined")
    kept["json"] = browser.run("window.blob.text()")


def check_reconnection(browser):
    """A lost connection is made anew, and shows the image again."""
    count, revision = browser.run("window.sockets.length"), browser.run(f"{STATE}.frames[0].revision")
    browser.run(f"window.lost = false; window.watch = setInterval(() => window.lost ||= {STATE}.connection === 'lost', 5);"
                " window.sockets.at(-1).close(); true")
    browser.wait_for(f"window.lost && window.sockets.length > {count} && {STATE}.connection === 'open'")
    wait_final(browser, revision)
    browser.run("clearInterval(window.watch); true")
    assert not browser.run("document.querySelector('#troubles').textContent")


# ---- runs ----

# Keeps the page's connections in window.sockets.
SOCKETS = """window.sockets = [];
window.WebSocket = class extends WebSocket { constructor(...all) { super(...all); window.sockets.push(this); } };"""

def run(address, *checks):
    """77 where there is no browser."""
    if find_browser() is None:
        print("there is no Chromium")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        here = os.getcwd()
        os.chdir(folder)
        with Browser(1280, 800, dark=True, webgl=True) as browser:
            browser.call("Page.addScriptToEvaluateOnNewDocument", source=SOCKETS)
            browser.open(address)
            for check in checks:
                check(browser)
            own = urlsplit(address).netloc
            elsewhere = [url for url in browser.requests if urlsplit(url).scheme != "blob" and urlsplit(url).netloc != own]
            assert not elsewhere, elsewhere
            assert not browser.errors, browser.errors
        os.chdir(here)
    return 0


def main(address):
    return run(address, check_image, check_display, check_wipe, check_pin, check_edit, check_method, check_camera, check_reconnection)


def kept(address, found):
    return run(address, lambda browser: check_kept(browser, found))


def sequence(address, folder, last):
    return run(address, lambda browser: check_sequence(browser, folder, last))


def remote(address, row):
    return run(address, lambda browser: check_remote(browser, row))


def photo(address):
    return run(address, check_photo)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
