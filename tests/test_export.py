#!/usr/bin/env python3
"""`tyndall export`: the coefficients of probes give our irradiance by each engine's own formula, lightmaps hold the bake's light,
importers name what there is; `tyndall unwrap` keeps triangles; and what is refused. usage: test_export.py TYNDALL EXAMPLES (works in the current folder)"""
import json, math, os, random, re, shutil, struct, subprocess, sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from ktx2 import read_floats

TYNDALL, EXAMPLES = sys.argv[1], sys.argv[2]
ENGINES = ("three", "godot", "unity", "unreal")


def tyndall(*arguments):
    subprocess.run([TYNDALL, *arguments, "-q"], check=True)


def refused(text, *arguments):
    done = subprocess.run([TYNDALL, *arguments], capture_output=True, text=True)
    assert done.returncode == 2 and text in done.stderr and done.stderr.count("\n") == 1, (arguments, done)


# ---- irradiance ----

def irradiance(sh, n):
    """E of a probe as tyndall bake stores it: sum of A_l L_lm Y_lm (docs/bake.md)."""
    x, y, z = n
    k1, k2, k20 = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi)), math.sqrt(5 / (16 * math.pi))
    harmonics = [math.sqrt(1 / (4 * math.pi)), k1 * y, k1 * z, k1 * x, k2 * x * y, k2 * y * z, k20 * (3 * z * z - 1),
                 k2 * x * z, k2 / 2 * (x * x - y * y)]
    lobe = [math.pi] + 3 * [2 * math.pi / 3] + 5 * [math.pi / 4]
    return [sum(lobe[t] * sh[t][c] * harmonics[t] for t in range(9)) for c in range(3)]


def three(sh, n):
    """SphericalHarmonics3.getIrradianceAt: radiance's coefficients to irradiance."""
    x, y, z = n
    weights = [0.886227, 2 * 0.511664 * y, 2 * 0.511664 * z, 2 * 0.511664 * x, 2 * 0.429043 * x * y, 2 * 0.429043 * y * z,
               0.743125 * z * z - 0.247708, 2 * 0.429043 * x * z, 0.429043 * (x * x - y * y)]
    return [sum(weights[t] * sh[t][c] for t in range(9)) for c in range(3)]


def godot(sh, n):
    """The light of LightmapGI's probes in Godot 4's scene shader, which albedo multiplies: E / pi."""
    x, y, z = n
    weights = [0.886227, 1.023327 * y, 1.023327 * z, 1.023327 * x, 0.858086 * x * y, 0.858086 * y * z,
               0.247708 * (3 * z * z - 1), 0.858086 * x * z, 0.429043 * (x * x - y * y)]
    return [math.pi * sum(weights[t] * sh[t][c] for t in range(9)) for c in range(3)]


def unity(sh, n):
    """ShadeSH9 of Unity, with its vectors made of SphericalHarmonicsL2 as the engine does; albedo multiplies it: E / pi."""
    x, y, z = n
    result = []
    for c in range(3):
        s = [sh[t][c] for t in range(9)]
        a, b, last = (s[3], s[1], s[2], s[0] - s[6]), (s[4], s[5], 3 * s[6], s[7]), s[8]
        value = sum(p * q for p, q in zip(a, (x, y, z, 1)))
        value += sum(p * q for p, q in zip(b, (x * y, y * z, z * z, z * x)))
        result.append(math.pi * (value + last * (x * x - y * y)))
    return result


def unreal(sh, n):
    """The scalar product with CalcDiffuseTransfer of Unreal, whose basis has signs (-1)^m."""
    x, y, z = n
    basis = [0.282095, -0.488603 * y, 0.488603 * z, -0.488603 * x, 1.092548 * x * y, -1.092548 * y * z,
             0.315392 * (3 * z * z - 1), -1.092548 * x * z, 0.546274 * (x * x - y * y)]
    lobe = [math.pi] + 3 * [2 * math.pi / 3] + 5 * [math.pi / 4]
    return [sum(lobe[t] * basis[t] * sh[t][c] for t in range(9)) for c in range(3)]


FORMULAS = {"three": three, "godot": godot, "unity": unity, "unreal": unreal}


def to_engine(engine, v, up):
    """A direction of the scene in an engine's axes, by way of glTF's."""
    x, y, z = v if up == "+y" else (v[0], v[2], -v[1])
    return {"three": (x, y, z), "godot": (x, y, z), "unity": (-x, y, z), "unreal": (x, z, y)}[engine]


def check_probes(up):
    folder = "baked_" + up[1]
    scene = {"tyndall": 1, "up_axis": up[1],
             "lights": [{"type": "environment", "radiance": [0.1, 0.15, 0.2]},
                        {"type": "point", "position": [1, 2, 3], "intensity": [9, 6, 3]}],
             "geometry": [{"quad": {"origin": [-2, -1, -2], "u": [0, 0, 4], "v": [4, 0, 0]}, "material": {"albedo": [0.8, 0.4, 0.2]}}]}
    json.dump(scene, open(f"probes_{up[1]}.json", "w"))
    json.dump([[0.2, 0.3, 0.4], [-0.7, 0.5, 0.1]], open("points.json", "w"))
    tyndall("bake", f"probes_{up[1]}.json", "-o", folder, "--probes", "points.json", "--grid", "2,3,2", "--spp", "64")
    baked = json.load(open(f"{folder}/probes.json"))["probes"]
    tyndall("bake", f"probes_{up[1]}.json", "-o", folder + "_5", "--probes", "points.json", "--spp", "1", "--sh", "5")
    for of, notes in ((folder, []), (folder + "_5", ["left out: probes: bands above the third"])):
        tyndall("export", of, "-o", "notes")
        assert json.load(open("notes/export.json"))["comment"] == notes, of
    chance = random.Random(1)
    for engine in ENGINES:
        tyndall("export", folder, "-o", f"{folder}_{engine}", "--for", engine)
        given = json.load(open(f"{folder}_{engine}/probes.json"))
        grid = json.load(open(f"{folder}_{engine}/grid.json"))
        assert grid["grid"] == [2, 3, 2] and len(grid["probes"]) == 12 and given["engine"] == engine
        worst = 0
        for ours, theirs in zip(baked, given["probes"]):
            scale = 100 if engine == "unreal" else 1
            expected = [scale * v for v in to_engine(engine, ours["position"], up)]
            assert all(abs(a - b) < 1e-5 * scale for a, b in zip(expected, theirs["position"])), (expected, theirs["position"])
            coefficients = [theirs["coefficients"][3 * t:3 * t + 3] for t in range(9)]
            for _ in range(20):
                n = [chance.gauss(0, 1) for _ in range(3)]
                n = [v / math.sqrt(sum(w * w for w in n)) for v in n]
                a, b = irradiance(ours["sh"], n), FORMULAS[engine](coefficients, to_engine(engine, n, up))
                worst = max(worst, max(abs(p - q) / sum(a) for p, q in zip(a, b)))
        print(f"{engine}, {up} up: irradiance by its formula within {worst:.1e}")
        assert worst < 1e-5, engine  # the formulas' constants have six digits


# ---- lightmaps ----

def check_lightmaps():
    subprocess.run([sys.executable, os.path.join(EXAMPLES, "make_room.py"), "room.glb"], check=True)
    tyndall("bake", "room.glb", "-o", "room", "--spp", "16", "--size", "96x64")
    width, height, light = read_floats(TYNDALL, "room/walls.exr")
    for engine, extension, scale in (("three", "ktx2", 1), ("godot", "dds", 1 / math.pi), ("unity", "dds", 1 / math.pi),
                                     ("unreal", "exr", 1 / math.pi)):
        tyndall("export", "room", "-o", engine, "--for", engine)
        listed = json.load(open(f"{engine}/export.json"))
        walls = next(m for m in listed["lightmaps"] if m["file"] == f"walls.{extension}")
        assert walls["meshes"] == [{"name": "walls", "node": 0, "primitive": 0}], walls
        assert listed["vertex_colors"] == "room.glb" and listed["color_scale"] > 0
    assert all(abs(math.pi * a - b) <= 1e-6 * b for a, b in zip(read_floats(TYNDALL, "unreal/walls.exr")[2][:3], light[:3]))
    if shutil.which("oiiotool") is None:
        print("left out: DDS by another reader, as oiiotool is not installed (scripts/setup.sh corpora)")
        return
    for engine in ("godot", "unity"):
        subprocess.run(["oiiotool", f"{engine}/walls.dds", "-d", "float", "--ch", "R,G,B", "-o", f"{engine}.exr"], check=True)
        found = read_floats(TYNDALL, f"{engine}.exr")[2]
        error, total = 0, 0
        for y in range(height):
            row = height - 1 - y if engine == "unity" else y
            for k in range(4 * width):
                if k % 4 < 3:
                    error += (math.pi * found[4 * width * row + k] - light[4 * width * y + k])**2
                    total += light[4 * width * y + k]**2
        print(f"{engine}: lightmap by BC6H within {100 * math.sqrt(error / total):.2f} % of its RMS")
        assert error < 0.0064 * total, engine  # measured: 5.9 %, of a map of 16 paths a texel, whose noise is larger


# ---- unwrap ----

def read_glb(path):
    data = open(path, "rb").read()
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length]), data[28 + length:]


def elements(gltf, body, index):
    a = gltf["accessors"][index]
    view = gltf["bufferViews"][a["bufferView"]]
    code, size = {5126: ("f", 4), 5125: ("I", 4), 5123: ("H", 2)}[a["componentType"]]
    count = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
    at, stride = view.get("byteOffset", 0) + a.get("byteOffset", 0), view.get("byteStride", count * size)
    return [struct.unpack_from(f"<{count}{code}", body, at + stride * i) for i in range(a["count"])]


def triangles(gltf, body, name):
    """Corners of a mesh's triangles, by position and normal."""
    found = []
    for primitive in next(m for m in gltf["meshes"] if m["name"] == name)["primitives"]:
        position, normal = (elements(gltf, body, primitive["attributes"][key]) for key in ("POSITION", "NORMAL"))
        index = [i[0] for i in elements(gltf, body, primitive["indices"])]
        found += [tuple((position[k], normal[k]) for k in index[i:i + 3]) for i in range(0, len(index), 3)]
    return sorted(found)


def check_unwrap():
    """The ball gets a lightmap; its triangles stay, and so do the lightmaps of the others."""
    done = subprocess.run([TYNDALL, "unwrap", "room.glb", "-o", "unwrapped.glb", "--density", "24", "--json"],
                          capture_output=True, text=True, check=True)
    found, = json.loads(done.stdout)
    assert found["mesh"] == "ball" and found["stretch"] <= 1.5 and 0.2 < found["fill"] < 1 and found["charts"] < 50, found
    before, after = read_glb("room.glb"), read_glb("unwrapped.glb")
    for name in ("ball", "walls", "table"):
        assert triangles(*before, name) == triangles(*after, name), name
    assert "TEXCOORD_1" in next(m for m in after[0]["meshes"] if m["name"] == "ball")["primitives"][0]["attributes"]
    tyndall("bake", "unwrapped.glb", "-o", "unwrapped", "--lightmaps", "--spp", "16", "--density", "16", "--method", "surfaces")
    assert os.path.exists("unwrapped/ball.exr")
    refused("-o FILE is missing", "unwrap", "room.glb")
    refused("is not .glb or .gltf", "unwrap", "room.obj", "-o", "a.glb")
    refused("is not .glb", "unwrap", "room.glb", "-o", "a.gltf")
    refused("gone.glb", "unwrap", "gone.glb", "-o", "a.glb")
    gltf, body = before
    gltf["meshes"][-1]["primitives"][0]["targets"] = [{"POSITION": gltf["meshes"][-1]["primitives"][0]["attributes"]["POSITION"]}]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    with open("morphed.glb", "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(body)) + struct.pack("<I4s", len(text), b"JSON") + text +
                   struct.pack("<I4s", len(body), b"BIN\0") + body)
    refused("morph targets cannot be given new vertices", "unwrap", "morphed.glb", "-o", "a.glb")


def check_refusals():
    refused("-o FOLDER is missing", "export", "room")
    refused("gone/bake.json", "export", "gone", "-o", "out")
    refused("none of three", "export", "room", "-o", "out", "--for", "source")
    refused("the bake itself is there", "export", "room", "-o", "room")
    os.makedirs("other", exist_ok=True)
    for text, message in (("{", "other/bake.json:1"), ("{}", "not the list of a bake"),
                          ('{"tyndall_bake": 1, "complete": false}', "--resume"),
                          ('{"tyndall_bake": 1, "complete": true, "files": [{"kind": "probes", "file": "p.json"}]}', "other/p.json"),
                          ('{"tyndall_bake": 1, "complete": true, "files": [{"kind": "lightmap", "file": "p.exr"}]}', "other/p.exr"),
                          ('{"tyndall_bake": 1, "complete": true, "files": [{"kind": "lightmap", "file": "../p.exr"}]}', "another folder")):
        open("other/bake.json", "w").write(text)
        refused(message, "export", "other", "-o", "out")


# ---- importers ----

def check_importers():
    """No engine is here: their files name only what there is, and read only what export.json and its like have."""
    godot = os.path.join(EXAMPLES, "godot")
    script = open(os.path.join(godot, "addons/tyndall/tyndall_level.gd")).read()
    scene = open(os.path.join(godot, "level.tscn")).read()
    project = open(os.path.join(godot, "project.godot")).read()
    named = re.findall(r'"res://([^"]+\.(?:gd|gdshader|tscn))"', script + scene + project)
    assert len(named) >= 5 and all(os.path.exists(os.path.join(godot, name)) for name in named), named
    for shader in (name for name in named if name.endswith(".gdshader")):
        text = open(os.path.join(godot, shader)).read()
        assert text.count("{") == text.count("}") and "shader_type spatial;" in text, shader
        uniforms = set(re.findall(r"uniform \w+ (\w+)", text))
        assert uniforms & set(re.findall(r'"(\w+)"', script)), shader
    for parameter in re.findall(r'set_shader_parameter\("(\w+)"', script):
        assert any(parameter in open(os.path.join(godot, name)).read() for name in named if name.endswith(".gdshader")), parameter
    export, grid = json.load(open("godot/export.json")), json.load(open("baked_y_godot/grid.json"))
    json.dump({"tyndall": 1, "media": [{"bounds": [[0, 0, 0], [1, 1, 1]], "sigma_t": 1, "albedo": 0.5}],
               "lights": [{"type": "environment", "radiance": [1, 1, 1]}]}, open("fog.json", "w"))
    tyndall("fluence", "fog.json", "-o", "fog_texture.dds", "--size", "4,4,4")
    known = set(export) | set(export["lightmaps"][0]) | set(export["lightmaps"][0]["meshes"][0]) | set(grid) | set(grid["probes"][0])
    known |= set(json.load(open("fog_texture.json")))
    read = set(re.findall(r'(?:files|fog|map|mesh|probe)\["(\w+)"\]', script)) | set(re.findall(r'get\("(\w+)"', script))
    assert read <= known, read - known
    unreal_script = open(os.path.join(EXAMPLES, "unreal/tyndall_import.py")).read()
    compile(unreal_script, "tyndall_import.py", "exec")
    assert set(re.findall(r'(?:export|lightmap|mesh|p)\["(\w+)"\]', unreal_script)) <= known
    text = open(os.path.join(EXAMPLES, "unity/TyndallImporter.cs")).read()
    fields = set(re.findall(r"public (?:string|int|float|float\[\]|Lightmap\[\]|MeshEntry\[\]|Probe\[\]) ([\w, ]+);", text))
    names = {name.strip() for field in fields for name in re.sub(r"public \w+ ", "", field).split(",")}
    assert text.count("{") == text.count("}") and names <= known | {"probes"}, names - known


check_probes("+y")
check_probes("+z")
check_lightmaps()
check_importers()
check_unwrap()
check_refusals()
