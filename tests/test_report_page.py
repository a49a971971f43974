#!/usr/bin/env python3
"""The page of tyndall compare in a headless Chromium. usage: test_report_page.py TYNDALL (in a scratch folder)

Without Chromium it says so in one line and ends with 77: skipped."""
import json, os, subprocess, sys

sys.dont_write_bytecode = True
from chromium import Browser, find_browser

tyndall = os.path.abspath(sys.argv[1])
checks, failures = 0, 0
SIZE = (40, 30)


def check(good, what):
    global checks, failures
    checks += 1
    if not good:
        failures += 1
        print("FAILED:", what)


# A medium that screen does not take.
UNEVEN = ("-D", 'media[0].density={"noise": {"seed": 1}}')


def run(*arguments):
    return subprocess.run([tyndall, *arguments], check=True, capture_output=True, text=True).stdout


def make_reports():
    size = "x".join(map(str, SIZE))
    run("compare", "builtin:cornell_fog", *UNEVEN, "--methods", "path,fld,screen,lpv", "-o", "scene", "--size", size, "--spp",
        "16", "--seed", "3", "--reference-spp", "64", "-q")
    run("render", "builtin:cornell_fog", "-o", "a'<b>&\".exr", "--size", size, "--spp", "2", "-q")
    run("compare", "scene/reference.exr", "scene/fld.exr", "a'<b>&\".exr", "-o", "images", "-q")


def value_of(method, x, y, spp, seed):
    """R, G and B of one pixel, rendered alone: bit for bit that of the whole image."""
    run("render", "builtin:cornell_fog", *UNEVEN, "--method", method, "--spp", str(spp), "--seed", str(seed), "--size",
        "x".join(map(str, SIZE)), "--crop", f"{x},{y},1x1", "-o", "pixel.exr", "-q")
    lines = [line.split() for line in run("info", "pixel.exr").splitlines()]
    return [next(float(line[2]) for line in lines if line[0] == name) for name in "RGB"]


class Page:
    def __init__(self, browser, path):
        self.browser = browser
        browser.open("file://" + os.path.abspath(path))
        self.drawn()

    def drawn(self):
        self.browser.wait_for("document.documentElement.dataset.drawn !== undefined")

    def press(self, key, times=1, **more):
        for _ in range(times):
            self.browser.press(key, **more)
        self.drawn()

    def focus(self, identity):
        self.browser.run(f"document.getElementById('{identity}').focus()")

    def value(self, identity):
        return self.browser.run(f"document.getElementById('{identity}').value")

    def text(self, identity):
        return self.browser.run(f"document.getElementById('{identity}').textContent")

    def pixels(self):
        return self.browser.run("(copy => { copy.drawImage(canvas, 0, 0); "
                                "return Array.from(copy.getImageData(0, 0, canvas.width, canvas.height).data); })"
                                "(new OffscreenCanvas(canvas.width, canvas.height).getContext('2d'))")

    def place(self, u, v):
        """Where in the window a point of the canvas is, 0..1 of it; brought into view."""
        self.browser.run("canvas.scrollIntoView({block: 'center'})")
        box = self.browser.run("(b => [b.left, b.top, b.width, b.height])(canvas.getBoundingClientRect())")
        return box[0] + u * box[2], box[1] + v * box[3]

    def mouse(self, kind, u, v, **more):
        self.browser.mouse(kind, *self.place(u, v), **more)
        self.drawn()

    def shown(self):
        """What the magnifier says: rows of left, right and their ratio."""
        rows = self.browser.run("[...document.querySelectorAll('#values tr')].map(row => "
                                "[...row.querySelectorAll('td')].map(cell => cell.textContent))")
        return [[float(cell) for cell in row] for row in rows]


def close(a, b):
    return abs(a - b) <= 2e-3 * abs(b) + 1e-9


def test_loading(page):
    check(page.text("title") == "builtin:cornell_fog", "the title: " + page.text("title"))
    check("64 samples per pixel" in page.text("about"), "the reference: " + page.text("about"))
    check("of its mean" in page.text("noise"), "the noise: " + page.text("noise"))
    check(len(set(page.pixels())) > 20, "the canvas is nearly empty")
    check(page.browser.run("canvas.width") == SIZE[0], "the canvas has another size than the image")
    names = page.browser.run("[...document.querySelectorAll('#left option')].map(option => option.textContent)")
    check([name.split()[0] for name in names] == ["reference", "path", "fld", "lpv"], f"the images: {names}")


def test_slider(page):
    before = page.pixels()
    page.mouse("mousePressed", 0.5, 0.5, button="left", clickCount=1, buttons=1)
    for u in (0.4, 0.3, 0.2):
        page.mouse("mouseMoved", u, 0.5, button="left", buttons=1)
    page.mouse("mouseReleased", 0.2, 0.5, button="left", clickCount=1)
    after = page.pixels()
    check(abs(float(page.value("cut")) - 20) < 2, "the slider is at " + page.value("cut"))
    rows = [(before[4 * SIZE[0] * y:4 * SIZE[0] * (y + 1)], after[4 * SIZE[0] * y:4 * SIZE[0] * (y + 1)])
            for y in range(SIZE[1])]
    left, between, right = 4 * 7, 4 * 20, 4 * SIZE[0]
    check(all(a[:left] == b[:left] for a, b in rows), "dragging changed what is left of both cuts")
    check(any(a[left + 8:between - 8] != b[left + 8:between - 8] for a, b in rows), "dragging changed nothing")
    check(all(a[between + 8:right] == b[between + 8:right] for a, b in rows), "dragging changed what is on the right")
    page.focus("cut")
    page.press("ArrowRight", 10)
    check(float(page.value("cut")) > 24, "keys do not move the slider: " + page.value("cut"))


def test_flip(page):
    page.focus("canvas")
    page.press("f")
    second = page.pixels()
    check(page.text("name-left") != "reference" and page.browser.run("view.mode") == "flip", "F does not flip")
    page.press(" ", code="Space")
    first = page.pixels()
    check(page.text("name-left") == "reference" and first != second, "space does not flip back")
    page.browser.run("document.getElementById('flip').click()")
    page.drawn()
    check(page.pixels() == second, "the button does not flip")
    x, y = page.place(0.3, 0.3)
    for kind in ("mousePressed", "mouseReleased"):
        page.browser.mouse(kind, x, y, button="left", clickCount=1)
    page.drawn()
    check(page.pixels() == first, "a click does not flip")
    page.focus("canvas")
    page.press("s")
    check(page.text("name-left") != "reference" and page.pixels() == second, "S does not swap")
    page.press("s")


def test_choice(page):
    was = page.value("right")
    page.browser.run("change({mode: 'flip', flipped: true})")
    page.drawn()
    before = page.pixels()
    page.focus("right")
    page.press("ArrowUp")
    check(page.value("right") != was and page.pixels() != before, "the arrow keys do not choose another image")
    page.focus("canvas")
    page.press(str(int(was) + 1), code="Digit" + str(int(was) + 1))
    check(page.value("right") == was and page.pixels() == before, "digits do not choose images")
    page.press("@", code="Digit2", shift=True)
    check(page.value("left") == "1", "digits with shift do not choose the left image: " + page.value("left"))


def test_display(page):
    first = page.pixels()
    page.focus("exposure")
    page.press("ArrowRight", 4)
    brighter = page.pixels()
    check(sum(brighter) > sum(first), "more exposure does not make it brighter")
    page.focus("canvas")
    page.press("0", code="Digit0")
    check(page.pixels() == first, "0 does not reset the exposure")
    page.press("+", code="NumpadAdd")
    check(sum(page.pixels()) > sum(first), "plus does not expose more")
    page.browser.run("document.getElementById('reset').click()")
    page.drawn()
    page.focus("display")
    page.press("ArrowDown")
    false_colors = page.pixels()
    check(page.value("display") == "luminance" and false_colors != first, "luminance in false colours is as colour")
    check(not page.browser.run("document.getElementById('scale').hidden"), "false colours have no scale")
    page.press("ArrowDown")
    errors = page.pixels()
    check(page.value("display") == "error" and errors not in (first, false_colors), "errors do not show")
    page.browser.run("change({right: view.left})")
    page.drawn()
    check(len(set(page.pixels())) <= 4, "an image differs from itself")
    page.browser.run("change({display: 'color', mode: 'slider'})")
    page.drawn()


def test_magnifier(page):
    page.browser.run("change({left: images[0], right: images[1]})")
    page.drawn()
    x, y = 12, 17
    page.mouse("mouseMoved", (x + 0.5) / SIZE[0], (y + 0.5) / SIZE[1])
    check(f"x {x}, y {y} of 40" in page.text("place"), "the place: " + page.text("place"))
    reference, path = value_of("path", x, y, 64, 4), value_of("path", x, y, 16, 3)
    for row, a, b in zip(page.shown(), reference, path):
        check(close(row[0], a) and close(row[1], b) and close(row[2], b / a), f"{row} is not {a}, {b}, {b / a}")
    page.focus("canvas")
    page.press("ArrowRight")
    page.press("ArrowDown", shift=True)
    check(f"x {x + 1}, y {y + 10} of 40" in page.text("place"), "keys moved to " + page.text("place"))
    for row, a in zip(page.shown(), value_of("path", x + 1, y + 10, 64, 4)):
        check(close(row[0], a), f"{row} is not {a}, after keys")
    check("luminance" in page.text("reading"), "nothing is said of the place: " + page.text("reading"))


def test_charts(page):
    circles = page.browser.run("document.querySelectorAll('#plot circle').length")
    labels = page.browser.run("[...document.querySelectorAll('#plot .label')].map(label => label.textContent)")
    check(circles >= 4 and {"path", "fld"} <= set(labels), f"the plot has {circles} points, {labels}")
    check("solve" in page.text("bars") and "surfaces" in page.text("bars"), "the stages: " + page.text("bars"))
    check("--seed 4 " in page.text("commands") and "--aov variance,samples" in page.text("commands"), "the commands: " + page.text("commands"))
    check('"tyndall": 1' in page.browser.run("document.querySelector('#scene pre').textContent"), "the scene's text")
    check(page.browser.run("document.querySelectorAll('#errors tbody tr').length") >= 2, "the table of errors")
    page.browser.run("document.getElementById('channels').click()")
    check(page.browser.run("document.querySelectorAll('#errors tbody tr').length") >= 8, "the channels of errors")
    skipped = page.browser.run("document.querySelector('#skipped ul').textContent")
    check("screen: media[0]" in skipped, "what is left out: " + skipped)


def test_keyboard(page):
    page = Page(page.browser, "scene/report.html")
    seen = []
    for _ in range(60):
        page.browser.press("Tab", text=None)
        at = page.browser.run("(e => [e.id || e.name || e.tagName, "
                              "getComputedStyle(e.name === 'mode' ? e.nextElementSibling : e).outlineStyle])"
                              "(document.activeElement)")
        if at[0] == "BODY" or (seen and at == seen[0]):
            break
        seen.append(at)
    names = [name for name, _ in seen]
    for name in ("left", "swap", "right", "mode", "canvas", "cut", "display", "exposure", "reset", "channels", "PRE",
                 "SUMMARY"):
        check(name in names, f"Tab does not reach {name}: {names}")
    check(all(style != "none" for _, style in seen), f"focus is not seen on all of {seen}")
    page.browser.call("Accessibility.enable")
    for node in page.browser.call("Accessibility.getFullAXTree")["nodes"]:
        focusable = any(p["name"] == "focusable" and p["value"]["value"] for p in node.get("properties", []))
        if focusable and not node["ignored"] and node["role"]["value"] not in ("RootWebArea", "generic"):
            check(node.get("name", {}).get("value"), f"something without a name: {node['role']['value']}")


def test_sizes(browser, page):
    for width in (400, 800, 1280):
        browser.resize(width, 800)
        wide = browser.run("document.documentElement.scrollWidth")
        check(wide <= width, f"at {width} pixels the page is {wide} wide")
    light = browser.run("getComputedStyle(document.body).backgroundColor")
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    check(browser.run("getComputedStyle(document.body).backgroundColor") != light, "dark is as light")


def main():
    if find_browser() is None:
        print("skipped: no Chromium (scripts/setup.sh page installs it)")
        return 77
    make_reports()
    with Browser() as browser:
        page = Page(browser, "scene/report.html")
        for test in (test_loading, test_slider, test_flip, test_choice, test_display, test_magnifier, test_charts,
                     test_keyboard):
            test(page)
        test_sizes(browser, page)
        page = Page(browser, "images/report.html")
        check("a'<b>&\".exr" in json.dumps(page.browser.run("report.images.map(entry => entry.source)"),
                                           ensure_ascii=False).replace('\\"', '"'), "the odd name is another one")
        check(browser.run("document.querySelectorAll('b').length") == 0, "a name became markup")
        wanted = {"file://" + os.path.abspath(path) for path in ("scene/report.html", "images/report.html")}
        check(set(browser.requests) <= wanted, f"requests: {set(browser.requests) - wanted}")
        check(not browser.errors, f"errors: {browser.errors}")
    print(f"{checks} checks, {failures} failed")
    return 0 if failures == 0 and checks >= 60 else 1


sys.exit(main())
