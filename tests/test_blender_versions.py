#!/usr/bin/env python3
"""What the Blender add-on reads of Blender, by the names of its versions 3.4 to 4.5, without Blender: stubs of sockets, meshes, lights
and the base class of render engines. The names are those of Blender's release notes and API change logs.
usage: test_blender_versions.py SOURCE"""
import importlib, math, os, sys, types
from unittest.mock import MagicMock

try:
    import numpy as np
except ImportError:
    if os.path.realpath(sys.executable) == os.path.realpath("/usr/bin/python3") or not os.path.exists("/usr/bin/python3"):
        print("skipped: this Python has no NumPy (scripts/setup.sh blender)")
        sys.exit(77)
    os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])  # the first in PATH may be another than the system's

sys.path.insert(0, os.path.join(os.path.abspath(sys.argv[1]), "addons", "blender"))

# Inputs of Principled BSDF: the names of 3.4, and of 4.0 and later (Blender 4.0 release notes, "Principled BSDF").
RENAMED = {"Subsurface": "Subsurface Weight", "Specular": "Specular IOR Level", "Transmission": "Transmission Weight",
           "Clearcoat": "Coat Weight", "Clearcoat Roughness": "Coat Roughness", "Sheen": "Sheen Weight", "Emission": "Emission Color"}
VALUES = {"Base Color": (0.8, 0.4, 0.2, 1), "Metallic": 0.25, "Roughness": 0.4, "IOR": 1.5, "Alpha": 1.0, "Subsurface": 0.1,
          "Specular": 0.7, "Transmission": 0.0, "Clearcoat": 0.6, "Clearcoat Roughness": 0.05, "Sheen": 0.3, "Emission": (1, 0.5, 0.25, 1),
          "Emission Strength": 2.0, "Anisotropic": 0.2, "Normal": (0, 0, 0)}
# Added since: Sheen Roughness (4.0), Thin Film Thickness (4.2), Diffuse Roughness (4.3).
ADDED = {"4.0": {"Sheen Roughness": 0.5}, "4.2": {"Thin Film Thickness": 0.0}, "4.3": {"Diffuse Roughness": 0.0}}
VERSIONS = ("3.4", "4.0", "4.1", "4.2", "4.3", "4.4", "4.5")


class Sockets(list):
    def __getitem__(self, key):
        return next(s for s in self if s.name == key) if isinstance(key, str) else list.__getitem__(self, key)

    def get(self, key):
        return next((s for s in self if s.name == key), None)


def sockets_of(values):
    return Sockets(types.SimpleNamespace(name=name, default_value=value, enabled=True, is_linked=False, links=[], identifier=name)
                   for name, value in values.items())


def principled(version):
    values = {(name if version == "3.4" else RENAMED.get(name, name)): value for name, value in VALUES.items()}
    for since, added in ADDED.items():
        if version >= since:
            values.update(added)
    return types.SimpleNamespace(type="BSDF_PRINCIPLED", name="Principled BSDF", inputs=sockets_of(values), mute=False)


def check_materials():
    from tyndall.materials import Materials
    from tyndall.report import Report
    made = {}
    for version in VERSIONS:
        report = Report()
        out = Materials(MagicMock(), report)._principled(principled(version), (), 'material "A"')
        made[version] = (out, report.lines())
    first, notes = made["3.4"]
    extensions = first["extensions"]
    assert extensions["KHR_materials_clearcoat"] == {"clearcoatFactor": 0.6, "clearcoatRoughnessFactor": 0.05}
    assert abs(extensions["KHR_materials_specular"]["specularColorFactor"][0] - 1.4) < 1e-12
    assert extensions["KHR_materials_emissive_strength"] == {"emissiveStrength": 2} and first["emissiveFactor"] == [1, 0.5, 0.25]
    assert len([n for n in notes if n.startswith("left out")]) == 2, notes  # subsurface scattering, anisotropy
    for version in VERSIONS[1:]:
        assert made[version] == made["3.4"], (version, made[version], made["3.4"])
    print(f"Principled BSDF: the same material and notes from {', '.join(VERSIONS)}")


class Column(list):
    """A collection with foreach_get."""

    def foreach_get(self, attribute, out):
        out[:] = np.ravel([item[attribute] for item in self])


def check_meshes():
    """calc_normals_split() is gone since 4.1, and the normals of corners are there without it."""
    from tyndall.meshes import triangles_of
    for removed in (False, True):
        mesh = types.SimpleNamespace(
            vertices=Column({"co": p} for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0))),
            loops=Column({"vertex_index": i, "normal": (0, 0, 1)} for i in range(3)),
            loop_triangles=Column([{"loops": (0, 1, 2), "material_index": 0}]),
            uv_layers=types.SimpleNamespace(active=None), calc_loop_triangles=lambda: None)
        if not removed:
            mesh.calc_normals_split = lambda: None
        found = triangles_of(types.SimpleNamespace(to_mesh=lambda: mesh, to_mesh_clear=lambda: None), np.eye(4))
        assert found.positions.shape == (3, 3) and np.allclose(found.normals, (0, 0, 1))
    print("meshes: normals of corners with and without calc_normals_split()")


def stub_bpy(version, base):
    bpy = MagicMock()
    bpy.app.version = version
    bpy.types = types.SimpleNamespace(RenderEngine=base, Operator=object, Panel=object, PropertyGroup=object, AddonPreferences=object)
    mathutils = types.SimpleNamespace(Vector=np.array, Matrix=np.array)
    sys.modules.update({"bpy": bpy, "mathutils": mathutils, "bpy_extras": MagicMock(), "bpy_extras.io_utils": MagicMock(),
                        "gpu": MagicMock(), "gpu_extras": MagicMock(), "gpu_extras.presets": MagicMock()})
    for name in [n for n in sys.modules if n.startswith("tyndall.")]:
        del sys.modules[name]


def check_engine():
    """The base class takes arguments and has a __del__ since 4.4, which has to be called."""
    deleted = []

    class Old:
        pass

    class New:
        def __init__(self, *arguments):
            self.arguments = arguments

        def __del__(self):
            deleted.append(self)

    for version, base, arguments in (((3, 4, 0), Old, ()), ((4, 4, 0), New, (1,))):
        stub_bpy(version, base)
        engine = importlib.import_module("tyndall.engine").TyndallEngine(*arguments)
        engine.viewport = MagicMock()
        viewport = engine.viewport
        engine.__del__()
        viewport.close.assert_called()
    assert len(deleted) == 1
    print("render engine: the destructor of 4.4 is called, and none is missed in 3.4")


def check_lights():
    """The cosine of spots is gone since 3.5; exposure and temperature came with 4.5."""
    for version, extra, expected in (((3, 4, 1), {}, None), ((3, 5, 0), {}, 10 / (4 * math.pi)),
                                     ((4, 5, 0), {"exposure": 1.0, "use_temperature": True, "temperature_color": (0.5, 0.5, 0.5)},
                                      10 / (4 * math.pi))):
        stub_bpy(version, object)
        lights, report = importlib.import_module("tyndall.lights"), importlib.import_module("tyndall.report")
        light = types.SimpleNamespace(name="Spot", type="SPOT", energy=10.0, color=(1, 1, 1), use_nodes=False, node_tree=None, shadow_soft_size=0.0,
                                      spot_size=1.0, spot_blend=0.2, **extra)
        matrix = MagicMock()
        matrix.copy.return_value = matrix
        matrix.translation = (0, 0, 0)
        matrix.to_scale.return_value = (1, 1, 1)
        matrix.to_3x3.return_value.__matmul__ = lambda self, v: types.SimpleNamespace(normalized=lambda: (0, 0, -1))
        out = lights.lights_of(types.SimpleNamespace(object=types.SimpleNamespace(data=light), matrix_world=matrix), report.Report())[0]
        cosine = (1 + math.cos(0.5)) / 2
        assert abs(out["intensity"][0] - (expected or 10 / (4 * math.pi) * cosine)) < 1e-9, (version, out)
    print("spots: the cosine of 3.4, and exposure and temperature of 4.5")


check_materials()
check_meshes()
check_engine()
check_lights()
