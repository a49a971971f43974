#!/usr/bin/env python3
"""Importers of engines, run as far as that goes without the engines: Unity's is compiled by mcs and run by mono against stubs,
Unreal's is run against a module of stubs, the functions of Godot's probes are run by Godot 3 after a translation into its
GDScript, and its script is parsed by tree-sitter-gdscript, where TYNDALL_NODE_MODULES names a folder that holds it.
usage: test_engine_scripts.py TYNDALL EXAMPLES (works in the current folder)"""
import json, math, os, re, shutil, subprocess, sys, types
from unittest.mock import MagicMock

TYNDALL, EXAMPLES = sys.argv[1], os.path.abspath(sys.argv[2])
HERE = os.path.dirname(os.path.abspath(__file__))
ENGINES = ("godot", "unity", "unreal")


def export(engine):
    folder = os.path.join(os.getcwd(), engine, "Assets", "files")
    shutil.rmtree(engine, ignore_errors=True)
    os.makedirs(os.path.dirname(folder))
    subprocess.run([TYNDALL, "export", "baked", "-o", folder, "--for", engine, "-q"], check=True)
    return folder


def near(a, b):
    return all(abs(x - y) <= 2e-6 * max(1, abs(y)) for x, y in zip(a, b)) and len(a) == len(b)


def left_out(part, why):
    print(f"left out: {part}, as {why}")


def probes_of(folder):
    return [p for p in json.load(open(os.path.join(folder, "grid.json")))["probes"] if p["blocked"] <= 0.5]


def check_unity():
    if not shutil.which("mcs") or not shutil.which("mono"):
        return left_out("Unity", "mcs and mono are not installed (mono-mcs)")
    folder = export("unity")
    subprocess.run(["mcs", "-warnaserror", "-nowarn:649", "-out:importer.exe", os.path.join(EXAMPLES, "unity/TyndallImporter.cs"),
                    os.path.join(HERE, "engines/unity_stubs.cs")], check=True)
    maps = {mesh["name"]: "Assets/files/" + m["file"] for m in json.load(open(os.path.join(folder, "export.json")))["lightmaps"]
            for mesh in m["meshes"]}
    out = subprocess.run(["mono", "importer.exe", folder, *maps, "another"], check=True, capture_output=True, text=True).stdout
    found = dict(re.findall(r"^mesh (.+) (\S+)$", out, re.M))
    assert maps and found == {**maps, "another": "-"}, found
    lines = [[float(v) for v in line.split()] for line in re.findall(r"^probe (.+)$", out, re.M)]
    assert len(lines) == len(probes_of(folder)) > 4
    for line, probe in zip(lines, probes_of(folder)):
        assert near(line, probe["position"] + probe["coefficients"]), (line, probe)
    print(f"Unity: {len(maps)} meshes, {len(lines)} probes by mono")


class Recorder(MagicMock):
    """A value of Unreal that keeps its editor properties."""

    def set_editor_property(self, name, value):
        self.__dict__.setdefault("kept", {})[name] = value

    def get_editor_property(self, name):
        kept = self.__dict__.setdefault("kept", {})
        return ["texture of " + os.path.basename(kept["filename"])] if name == "imported_object_paths" else kept[name]

    def _get_child_mock(self, **arguments):
        return MagicMock(**arguments)


def check_unreal():
    folder = export("unreal")
    meshes = [(mesh["name"], mesh["primitive"], m["file"])
              for m in json.load(open(os.path.join(folder, "export.json")))["lightmaps"] for mesh in m["meshes"]]
    unreal, actors, logged, volumes, instances = types.ModuleType("unreal"), [], [], [], {}
    for name in ("AssetToolsHelpers", "TextureCompressionSettings", "TextureMipGenSettings", "TextureAddress", "MaterialEditingLibrary",
                 "MaterialProperty", "MaterialShadingModel", "StaticMeshComponent", "EditorAssetLibrary", "EditorLevelLibrary",
                 "LightmassImportanceVolume", "Material", "MaterialFactoryNew", "MaterialInstanceConstant",
                 "MaterialInstanceConstantFactoryNew", "MaterialExpressionVectorParameter", "MaterialExpressionTextureCoordinate",
                 "MaterialExpressionTextureSampleParameter2D", "MaterialExpressionMultiply"):
        setattr(unreal, name, MagicMock())
    unreal.MaterialInstance = type("MaterialInstance", (), {})
    unreal.AssetImportTask = Recorder
    unreal.LinearColor = lambda *v: v
    unreal.Vector = lambda *v: v
    unreal.log = logged.append
    unreal.load_asset = lambda path: Recorder(name=path)
    unreal.EditorAssetLibrary.does_asset_exist.return_value = False
    unreal.EditorLevelLibrary.get_all_level_actors.return_value = actors
    unreal.EditorLevelLibrary.spawn_actor_from_class.side_effect = lambda kind, at: volumes.append(at) or MagicMock()
    unreal.MaterialEditingLibrary.set_material_instance_texture_parameter_value.side_effect = (
        lambda instance, key, texture: instances.setdefault(key, []).append(texture))
    for name, _, _ in meshes:
        actor = MagicMock()
        actor.get_actor_label.return_value = name
        actors.append(actor)
    sys.modules["unreal"], before = unreal, sys.argv
    sys.argv = ["tyndall_import.py", folder]
    script = {"__name__": "__main__"}
    exec(compile(open(os.path.join(EXAMPLES, "unreal/tyndall_import.py")).read(), "tyndall_import.py", "exec"), script)
    sys.argv = before
    for actor, (_, slot, _) in zip(actors, meshes):
        assert slot in [call.args[0] for call in actor.get_component_by_class.return_value.set_material.call_args_list]
    assert len(instances["Lightmap"]) == len(meshes) and len(volumes) == 1 and len(logged) == 1
    positions = [p["position"] for p in probes_of(folder)]
    assert near(volumes[0], [0.5 * (min(v) + max(v)) for v in zip(*positions)]), volumes
    for p, q in zip(probes_of(folder), probes_of(export("godot"))):  # another engine's axes and factors
        light, other = script["irradiance"](p["coefficients"], (0.48, 0.6, 0.64)), probe_light(q["coefficients"], (0.48, 0.64, 0.6))
        assert all(abs(a - math.pi * b) < 1e-5 * (abs(a) + 0.01) for a, b in zip(light, other)), (light, other)
    print(f"Unreal: {len(meshes)} meshes, {len(positions)} probes by stubs")


# GDScript of Godot 4 and what Godot 3 calls the same; slices have their last element in Godot 3.
TRANSLATION = [("PackedColorArray", "PoolColorArray"), (r"for (\w+): Dictionary in", r"for \1 in"), (r"nearest\.clear\(\)", "nearest.resize(0)"),
               (r"slice\(3 \* term, 3 \* term \+ 3\)", "slice(3 * term, 3 * term + 2)")]

DRIVER = """extends SceneTree

func _read(file):
	var handle = File.new()
	handle.open("res://" + file, File.READ)
	return parse_json(handle.get_as_text())

func _init():
	var points = _read("points.json")
	for p in points:
		var probe = nearest_probe(Vector3(p[0], p[1], p[2]))
		var light = probe_light(probe, Vector3(p[3], p[4], p[5]))
		printerr("light %.7f %.7f %.7f" % [light.r, light.g, light.b])
	quit()
"""


def check_godot():
    if not shutil.which("godot3-server"):
        return left_out("Godot's probes", "Godot 3 is not installed (godot3-server)")
    folder = export("godot")
    script = open(os.path.join(EXAMPLES, "godot/addons/tyndall/tyndall_level.gd")).read()
    functions = "".join(re.search(rf"^(?:static )?func {name}\(.*?(?=^\S|\Z)", script, re.M | re.S)[0] + "\n\n"
                        for name in ("nearest_probe", "probe_light"))
    for old, new in TRANSLATION:
        functions, count = re.subn(old, new, functions)
        assert count > 0, old
    os.makedirs("godot3", exist_ok=True)
    open("godot3/project.godot", "w").write("config_version=4\n")
    open("godot3/run.gd", "w").write(DRIVER + "\n" + functions.replace("static func", "func"))
    shutil.copy(os.path.join(folder, "grid.json"), "godot3/grid.json")
    probes = probes_of(folder)
    normals = [(0.6, 0.0, 0.8), (0.0, -1.0, 0.0), (0.48, 0.64, -0.6)]
    points = [[*(v + 0.01 for v in p["position"]), *normals[i % 3]] for i, p in enumerate(probes)]
    json.dump(points, open("godot3/points.json", "w"))
    done = subprocess.run(["godot3-server", "--path", "godot3", "-s", "run.gd"], capture_output=True, text=True, timeout=60)
    lights = [[float(v) for v in line.split()] for line in re.findall(r"^light (.+)$", done.stdout + done.stderr, re.M)]
    assert len(lights) == len(probes), done.stdout + done.stderr
    for light, probe, point in zip(lights, probes, points):
        assert near(light, probe_light(probe["coefficients"], point[3:])), (light, probe)
    print(f"Godot: {len(lights)} probes by Godot 3")


def probe_light(c, n):
    """Irradiance over pi of Godot's coefficients, L_lm / pi, by the clamped cosine's own moments."""
    pi, sqrt = math.pi, math.sqrt
    x, y, z = n
    harmonics = [sqrt(1 / (4 * pi))] + [sqrt(3 / (4 * pi)) * v for v in (y, z, x)]
    harmonics += [sqrt(15 / (4 * pi)) * v for v in (x * y, y * z, (3 * z * z - 1) / sqrt(12), x * z, (x * x - y * y) / 2)]
    cosine = [pi] + 3 * [2 * pi / 3] + 5 * [pi / 4]
    return [sum(a * h * c[3 * t + k] for t, (a, h) in enumerate(zip(cosine, harmonics))) for k in range(3)]


PARSE = """const Parser = require('tree-sitter'), parser = new Parser();
parser.setLanguage(require('tree-sitter-gdscript'));
let errors = 0;
(function walk(node) {
    if (node.type === 'ERROR' || node.isMissing) { ++errors; console.log('error in line ' + (node.startPosition.row + 1)); }
    node.children.forEach(walk);
})(parser.parse(require('fs').readFileSync(process.argv[2], 'utf8')).rootNode);
process.exit(errors ? 1 : 0);
"""


def check_grammar():
    modules = os.environ.get("TYNDALL_NODE_MODULES", "")
    if not os.path.isdir(os.path.join(modules, "tree-sitter-gdscript")) or not shutil.which("node"):
        return left_out("the grammar of GDScript", "TYNDALL_NODE_MODULES names no folder with tree-sitter and tree-sitter-gdscript")
    open("parse.cjs", "w").write(PARSE)
    subprocess.run(["node", "parse.cjs", os.path.join(EXAMPLES, "godot/addons/tyndall/tyndall_level.gd")], check=True,
                   env={**os.environ, "NODE_PATH": os.path.abspath(modules)})
    print("Godot: the script parses by tree-sitter-gdscript")


subprocess.run([sys.executable, os.path.join(EXAMPLES, "make_room.py"), "room.glb"], check=True)
shutil.copy(os.path.join(EXAMPLES, "three/level.json"), "level.json")
subprocess.run([TYNDALL, "bake", "level.json", "-o", "baked", "--spp", "2", "--cache", "8", "--lightmaps", "--vertices", "--density", "2", "--grid", "3,2,3", "-q"], check=True)
check_unity()
check_unreal()
check_godot()
check_grammar()
