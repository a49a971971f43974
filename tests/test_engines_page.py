#!/usr/bin/env python3
"""What engines load, in a headless Chromium's WebGL2: BC6H as the browser decodes it, the shader of examples/three/fog.js against
dom, and the sample in examples/three against dom and path.
usage: test_engines_page.py TYNDALL EXAMPLES (works in the current folder). TYNDALL_THREE names a folder of three.js, as npm
installs it; without one, and without EXAMPLES/three/node_modules/three, the sample is left out.
--picture FILE: writes a picture of the sample instead."""
import base64, copy, functools, http.server, json, os, re, shutil, subprocess, sys, threading

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Browser, find_browser
from ktx2 import read_floats

TYNDALL, EXAMPLES = sys.argv[1], sys.argv[2]
THREE = os.environ.get("TYNDALL_THREE") or os.path.join(EXAMPLES, "three", "node_modules", "three")

FOG_SCENE = {
    "tyndall": 1,
    "camera": {"position": [1.7, 1.1, 2.4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40, "resolution": [64, 64]},
    "media": [{"bounds": [[-1, -0.5, -1], [1, 0.5, 1]], "sigma_t": [1.2, 1.2, 1.2], "albedo": [0.95, 0.9, 0.8], "g": 0}],
    "lights": [{"type": "directional", "direction": [0.3, -1, -0.4], "irradiance": [3, 2.5, 2]}],
}

SUN = {"type": "directional", "direction": [0.3, -1, -0.4], "irradiance": [3, 2.5, 2]}
LAMP = {"type": "point", "position": [0.2, 1.1, -0.3], "intensity": [3, 2.5, 2]}
FOG_VIEWS = [("sun from above", SUN, [1.7, 1.1, 2.4]), ("sun from below", SUN, [1.2, -2.2, 1.4]), ("lamp", LAMP, [1.7, 1.1, 2.4]),
             ("against the lamp", LAMP, [1.2, -2.2, 1.4])]

PAGE = """<!doctype html><link rel="icon" href="data:,"><script type="module">
import { fogChunk } from './fog.js';
import { gridChunk } from './probes.js';
const gl = document.createElement('canvas').getContext('webgl2');
gl.getExtension('EXT_color_buffer_float');
function compile(fragment) {
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, '#version 300 es\\nvoid main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0.0, 1.0); }'], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    return (name) => gl.getUniformLocation(program, name);
}
function draw(width, height) {
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    const error = gl.getError();
    if (error) throw new Error('WebGL error ' + error);
    return Array.from(pixels);
}
async function level(file) { // the first level of a KTX2 file without compression
    const bytes = await (await fetch(file)).arrayBuffer(), view = new DataView(bytes);
    const [width, height, depth] = [20, 24, 28].map((at) => view.getUint32(at, true));
    return { width, height, depth, data: bytes.slice(view.getUint32(80, true), view.getUint32(80, true) + view.getUint32(88, true)) };
}
async function volume(unit, file) {
    const { width, height, depth, data } = await level(file);
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, width, height, depth, 0, gl.RGBA, gl.HALF_FLOAT, new Uint16Array(data));
    for (const name of ['MIN_FILTER', 'MAG_FILTER']) gl.texParameteri(gl.TEXTURE_3D, gl['TEXTURE_' + name], gl.LINEAR);
    for (const name of ['S', 'T', 'R']) gl.texParameteri(gl.TEXTURE_3D, gl['TEXTURE_WRAP_' + name], gl.CLAMP_TO_EDGE);
}
window.fog = async (file, box, camera, steps, light, bands) => {
    await volume(0, file);
    if (light) await volume(6, 'fog_uncollided.ktx2');
    if (light) await volume(7, 'fog_directions.ktx2');
    const at = compile(`#version 300 es
        precision highp float;
        ${light ? '#define FOG_LIGHT\\n#define FOG_BANDS ' + bands : ''}
        ${fogChunk}
        uniform vec3 eye, right, up, ahead;
        uniform vec2 size;
        out vec4 color;
        void main() {
            vec2 p = 2.0 * gl_FragCoord.xy / size - 1.0;
            color = fogAlong(eye, normalize(ahead + p.x * right + p.y * up), 1e9);
        }`);
    gl.uniform1i(at('fogTexture'), 0);
    gl.uniform1i(at('fogUncollided'), 6);
    gl.uniform1i(at('fogDirections'), 7);
    if (light) gl.uniform4fv(at('fogLight'), light);
    gl.uniform1i(at('fogSteps'), steps);
    gl.uniform3fv(at('fogLower'), box.lower);
    gl.uniform3fv(at('fogUpper'), box.upper);
    for (const name of ['eye', 'right', 'up', 'ahead']) gl.uniform3fv(at(name), camera[name]);
    gl.uniform2fv(at('size'), camera.size);
    return draw(...camera.size);
};
window.godotFog = async (shader, file, values, camera) => { // shader: of Godot, translated
    await volume(0, file);
    gl.activeTexture(gl.TEXTURE6);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // the far plane
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    const at = compile(shader);
    gl.uniform1i(at('fog'), 0);
    gl.uniform1i(at('depth_texture'), 6);
    gl.uniform1i(at('steps'), 64);
    gl.uniform1f(at('gain'), 1);
    for (const name of ['lower', 'upper']) gl.uniform3fv(at(name), values[name]);
    for (const name of ['INV_PROJECTION_MATRIX', 'INV_VIEW_MATRIX']) gl.uniformMatrix4fv(at(name), false, values[name]);
    gl.uniform2fv(at('size'), camera.size);
    return draw(...camera.size);
};
window.grid = async (box, positions, normals) => { // irradiance at each position
    const at = compile(`#version 300 es
        precision highp float;
        ${gridChunk}
        uniform vec3 positions[${positions.length}], normals[${positions.length}];
        out vec4 color;
        void main() { int i = int(gl_FragCoord.x); color = vec4(gridIrradiance(positions[i], normals[i]), 1.0); }`);
    for (let term = 0; term < 4; ++term) {
        await volume(2 + term, `grid/grid_${term}.ktx2`);
        gl.uniform1i(at('grid' + term), 2 + term);
    }
    gl.uniform3fv(at('gridLower'), box.lower);
    gl.uniform3fv(at('gridUpper'), box.upper);
    gl.uniform3fv(at('positions'), positions.flat());
    gl.uniform3fv(at('normals'), normals.flat());
    return draw(positions.length, 1);
};
window.bc6h = async (file) => {
    const bptc = gl.getExtension('EXT_texture_compression_bptc');
    if (!bptc) return null;
    const { width, height, data } = await level(file);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.compressedTexImage2D(gl.TEXTURE_2D, 0, file.includes('signed') ? bptc.COMPRESSED_RGB_BPTC_SIGNED_FLOAT_EXT : bptc.COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_EXT, width, height, 0, new Uint8Array(data));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    const at = compile(`#version 300 es
        precision highp float;
        uniform sampler2D image;
        out vec4 color;
        void main() { color = texelFetch(image, ivec2(gl_FragCoord.xy), 0); }`);
    gl.uniform1i(at('image'), 0);
    return draw(width, height);
};
window.ready = true;
</script>"""


def tyndall(*arguments):
    subprocess.run([TYNDALL, *arguments, "-q"], check=True)


def rotated(pixels, width, height):
    """Rows from the other end."""
    return [v for y in reversed(range(height)) for v in pixels[4 * width * y:4 * width * (y + 1)]]


def compare(a, b, width, height, block):
    """Ratio of the means, and relative RMSE of the means over blocks, the worst of red, green and blue."""
    ratio, error = 1, 0
    for c in range(3):
        mean = sum(b[c::4]) / (width * height)
        found = sum(a[c::4]) / (width * height) / mean
        squares = 0
        for y in range(0, height - block + 1, block):
            for x in range(0, width - block + 1, block):
                at = [4 * ((y + j) * width + x + i) + c for j in range(block) for i in range(block)]
                squares += (sum(a[k] - b[k] for k in at) / len(at))**2
        ratio = found if abs(found - 1) > abs(ratio - 1) else ratio
        error = max(error, (squares / (width // block * (height // block)))**0.5 / mean)
    return ratio, error


def check(name, found, ratio, error):
    print(f"{name}: mean ratio {found[0]:.4f}, relative RMSE of blocks {100 * found[1]:.2f} %")
    assert abs(found[0] - 1) < ratio and found[1] < error, name


def serve():
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory="."))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_port}/"


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def unit(v):
    length = sum(x * x for x in v)**0.5
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def camera_of(scene):
    import math
    c = scene["camera"]
    ahead = unit(sub(c["target"], c["position"]))
    right = unit(cross(ahead, c["up"]))
    half = math.tan(math.radians(c["fov_y"]) / 2)
    return {"eye": c["position"], "ahead": ahead, "right": [half * v for v in right],
            "up": [half * v for v in cross(right, ahead)], "size": c["resolution"]}


def check_bc6h(browser):
    """Chromium's decoder sees the light of dom's image; measured: the means within 0.13 %, blocks of 4 x 4 pixels within 0.7 %."""
    width, height, source = read_floats(TYNDALL, "fog.exr")
    for texels in ("bc6h", "bc6h-signed"):
        tyndall("convert", "fog.exr", f"{texels}.ktx2", "--texels", texels, "--no-zstd")
        found = browser.run(f"window.bc6h('{texels}.ktx2')")
        if found is None:
            print("skipped: this browser has no EXT_texture_compression_bptc")
            return
        check(texels, compare(found, source, width, height, 4), 0.005, 0.01)


def draw_fog(browser, scene, light, bands=5):
    box = json.load(open("fog.json"))
    pixels = browser.run(f"window.fog('fog.ktx2', {json.dumps(box)}, {json.dumps(camera_of(scene))}, 64, {json.dumps(light)}, {bands})")
    width, height, expected = read_floats(TYNDALL, "fog.exr")
    return compare(rotated(pixels, width, height), expected, width, height, 4)


def check_fog(browser):
    """The shader with 48 x 24 x 48 texels against dom, which takes single scattering at points. Measured with directions: means
    within 0.7 % and blocks within 1.3 % at g = 0.3; 2.1 and 5.3 % at 0.7, and with three bands of harmonics 4.2 and 8.1 %."""
    check("fog.js against dom", draw_fog(browser, FOG_SCENE, None), 0.01, 0.02)
    for g, views, bounds in ((0.3, FOG_VIEWS[:1], {1: (0.015, 0.025)}), (0.7, FOG_VIEWS, {5: (0.04, 0.07), 3: (0.06, 0.1)})):
        for name, light, eye in views:
            scene = copy.deepcopy(FOG_SCENE)
            scene["media"][0]["g"], scene["lights"], scene["camera"]["position"] = g, [light], eye
            json.dump(scene, open("fog_scene.json", "w"))
            tyndall("render", "fog_scene.json", "-o", "fog.exr", "--method", "dom")
            tyndall("fluence", "fog_scene.json", "-o", "fog.ktx2", "--size", "48,24,48", "--no-zstd", "--texture", "phase")
            at = light["direction"] + [0] if light["type"] == "directional" else light["position"] + [1]
            for bands, (ratio, error) in bounds.items():
                check(f"g = {g}, {name}, bands {bands}", draw_fog(browser, scene, at, bands), ratio, error)


def translate_godot(text):
    """A shader of Godot in GLSL ES 3.00: built-in values as globals, uniforms without hints and defaults, fragment() alone."""
    text = re.sub(r"^(shader_type|render_mode) .*;$", "", text, flags=re.M)
    text = re.sub(r"^(uniform \w+ \w+) [:=].*;", r"\1;", text, flags=re.M)
    text = re.sub(r"^void vertex\(\) \{.*?^\}$", "", text, flags=re.M | re.S)
    return f"""#version 300 es
        precision highp float;
        precision highp sampler3D;
        uniform mat4 INV_PROJECTION_MATRIX, INV_VIEW_MATRIX;
        uniform vec2 size;
        vec2 SCREEN_UV;
        vec3 ALBEDO;
        float ALPHA;
        out vec4 color;
        {text}
        void main() {{ SCREEN_UV = gl_FragCoord.xy / size; fragment(); color = vec4(ALBEDO * ALPHA, ALPHA); }}"""


def check_godot_fog(browser):
    """fog.gdshader with the values that Godot 4.3 gives: depth is 1 at the near plane and 0 at the far one."""
    camera, box, near, far = camera_of(FOG_SCENE), json.load(open("fog.json")), 0.05, 4000
    half = sum(v * v for v in camera["right"])**0.5
    values = {"lower": box["lower"], "upper": box["upper"],
              "INV_PROJECTION_MATRIX": [half, 0, 0, 0, 0, half, 0, 0, 0, 0, 0, (far - near) / (near * far), 0, 0, -1, 1 / far],
              "INV_VIEW_MATRIX": [*unit(camera["right"]), 0, *unit(camera["up"]), 0, *(-v for v in camera["ahead"]), 0, *camera["eye"], 1]}
    shader = translate_godot(open(os.path.join(EXAMPLES, "godot/addons/tyndall/fog.gdshader")).read())
    pixels = browser.run(f"window.godotFog({json.dumps(shader)}, 'fog.ktx2', {json.dumps(values)}, {json.dumps(camera)})")
    width, height, expected = read_floats(TYNDALL, "fog.exr")
    check("Godot's fog.gdshader against dom", compare(rotated(pixels, width, height), expected, width, height, 4), 0.01, 0.02)


def check_grid(browser):
    """The shader at the middle of cells against bands 0 and 1 of the probes there; half floats have 11 bits."""
    import random
    tyndall("bake", "fog_scene.json", "-o", "baked_grid", "--grid", "4,3,5", "--spp", "16")
    tyndall("export", "baked_grid", "-o", "grid", "--no-zstd")
    grid, chance = json.load(open("grid/grid.json")), random.Random(3)
    probes = grid["probes"][::4]
    normals = [unit([chance.gauss(0, 1) for _ in range(3)]) for _ in probes]
    found = browser.run(f"window.grid({json.dumps({k: grid[k] for k in ('lower', 'upper')})}, "
                        f"{json.dumps([p['position'] for p in probes])}, {json.dumps(normals)})")
    worst = 0
    for i, (probe, n) in enumerate(zip(probes, normals)):
        c = probe["coefficients"]
        for k in range(3):
            expected = max(0, 0.886227 * c[k] + 1.023327 * (c[3 + k] * n[1] + c[6 + k] * n[2] + c[9 + k] * n[0]))
            worst = max(worst, abs(found[4 * i + k] - expected) / (0.886227 * c[k]))
    print(f"probes.js: irradiance within {worst:.1e} of bands 0 and 1")
    assert worst < 2e-3


def make_level(*quality):
    for name in ("fog.js", "level.js", "main.js", "index.html", "level.json"):
        shutil.copy(os.path.join(EXAMPLES, "three", name), name)
    os.makedirs("node_modules", exist_ok=True)
    if not os.path.exists("node_modules/three"):
        os.symlink(os.path.abspath(THREE), "node_modules/three")
    subprocess.run([sys.executable, os.path.join(EXAMPLES, "make_room.py"), "room.glb"], check=True)
    tyndall("bake", "level.json", "-o", "baked", *quality)
    tyndall("export", "baked", "-o", "files")
    tyndall("fluence", "level.json", "-o", "files/fog.ktx2")
    shutil.copy("baked/room.glb", "files/room.glb")


def check_sample(browser, address):
    tyndall("render", "level.json", "-o", "dom.exr", "--method", "dom", "--size", "96x72")
    browser.open(address + "index.html?size=96x72&exposure=1")
    browser.wait_for("window.ready")
    found = browser.run("window.readRadiance()")
    width, height, expected = read_floats(TYNDALL, "dom.exr")
    check("three.js sample against dom", compare(rotated(found, width, height), expected, width, height, 8), 0.02, 0.07)
    tyndall("render", "level.json", "-o", "path.exr", "--method", "path", "--size", "96x72", "--spp", "64")
    check("three.js sample against path", compare(rotated(found, width, height), read_floats(TYNDALL, "path.exr")[2], width, height, 24),
          0.03, 0.1)


def take_picture(path):
    make_level()
    with Browser(640, 480, webgl=True) as browser:
        browser.open(serve() + "index.html?size=640x480&exposure=1.5")
        browser.wait_for("window.ready")
        with open(path, "wb") as file:
            file.write(base64.b64decode(browser.call("Page.captureScreenshot", format="png")["data"]))


def main():
    if find_browser() is None:
        print("skipped: no Chromium is installed (scripts/setup.sh page)")
        sys.exit(77)
    if "--picture" in sys.argv:
        return take_picture(sys.argv[sys.argv.index("--picture") + 1])
    json.dump(FOG_SCENE, open("fog_scene.json", "w"))
    tyndall("render", "fog_scene.json", "-o", "fog.exr", "--method", "dom")
    tyndall("fluence", "fog_scene.json", "-o", "fog_packed.ktx2", "--size", "48,24,48")
    tyndall("fluence", "fog_scene.json", "-o", "fog.ktx2", "--size", "48,24,48", "--no-zstd")
    assert os.path.getsize("fog_packed.ktx2") <= os.path.getsize("fog.ktx2")
    with open("page.html", "w") as file:
        file.write(PAGE)
    for name in ("fog.js", "probes.js"):
        shutil.copy(os.path.join(EXAMPLES, "three", name), name)
    address = serve()
    with Browser(320, 240, webgl=True) as browser:
        browser.open(address + "page.html")
        browser.wait_for("window.ready")
        check_bc6h(browser)
        check_godot_fog(browser)
        check_fog(browser)
        check_grid(browser)
        if os.path.isdir(THREE):
            make_level("--spp", "32", "--cache", "16")
            check_sample(browser, address)
        else:
            print("left out: the three.js sample, as three.js is not installed (npm install in examples/three, or TYNDALL_THREE)")
        assert not browser.errors, browser.errors


main()
