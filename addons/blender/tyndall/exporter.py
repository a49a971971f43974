"""Writes what a depsgraph holds as a scene file, with meshes as GLB files beside it and volumes where they are."""
import json
import os

import bpy
from mathutils import Vector

from . import glb, materials, media, meshes, volumes, world
from .camera import add_motion, camera_of, crop_of, size_of
from .lights import lights_of
from .nodes import output_of
from .report import Report, owner

SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


class Export:
    """One export. folder: where surfaces.glb and bounds_N.glb are written, their names after `prefix`; program: of Tyndall,
    or None."""

    def __init__(self, depsgraph, folder, program=None, size=None, prefix=""):
        self.depsgraph, self.folder, self.program, self.prefix = depsgraph, folder, program, prefix
        self.scene = depsgraph.scene
        self.size = size or size_of(self.scene)
        self.report = Report()
        self.media, self.lights, self.geometry, self.points = [], [], [], []
        self.writer = glb.Writer()
        self.materials = materials.Materials(self.writer, self.report)
        self.files = 0

    def _setting(self, name, default):
        """One of the panel, where the add-on is registered."""
        return getattr(getattr(self.scene, "tyndall", None), name, default)

    # ---- objects ----

    def _visit(self, instance):
        target = instance.object
        if target.type == "LIGHT":
            self.points.append(tuple(instance.matrix_world.translation))
            self.lights += lights_of(instance, self.report, self._setting("soft_lamps", True))
        elif target.type == "VOLUME":
            self._extend(target, instance.matrix_world)
            self.media += volumes.media_of_volume(target, instance.matrix_world, self.program, self.report)
        elif target.type in SURFACES:
            self._surface(target, instance.matrix_world.copy())
        elif target.type not in ("EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"):
            self.report.lose(owner("object", target), f"objects of type {target.type}")
        if target.particle_systems and any(s.settings.render_type == "PATH" for s in target.particle_systems):
            self.report.lose(owner("object", target), "hair")

    def _extend(self, target, matrix):
        self.points += [tuple(matrix @ Vector(corner)) for corner in target.bound_box]

    def _surface(self, target, matrix):
        triangles = meshes.triangles_of(target, matrix)
        if triangles is None:
            return
        self.points += [tuple(triangles.positions.min(0)), tuple(triangles.positions.max(0))]
        slots = [s.material for s in target.material_slots] or [None]
        shaders = [_volume_of(m) for m in slots]
        domain = volumes.domain_of_fluid(target)
        filled = next((i for i, s in enumerate(shaders) if s is not None), None)
        if filled is not None:
            if sum(s is not None for s in shaders) > 1 and len({id(s.node) for s in shaders if s is not None}) > 1:
                self.report.lose(owner("object", target), "volume shaders of its materials but the first")
            self._filled(target, matrix, triangles, slots, slots[filled], shaders[filled], domain)
            return
        if domain is not None:
            self.report.lose(owner("object", target), "a fluid domain without a volume shader")
            return
        self._add_surfaces(self.writer, self.materials, target, triangles, slots)

    def _add_surfaces(self, writer, known, target, triangles, slots):
        """Adds the triangles by material, but for those without a surface shader."""
        primitives = []
        for slot in sorted(set(triangles.slots.tolist())):
            material = slots[min(slot, len(slots) - 1)]
            if material is not None and material.use_nodes and _surface_of(material) is None:
                continue
            index = known.index(material)
            primitives.append(meshes.primitive_of(triangles, triangles.slots == slot, index, glb.y_up))
        if primitives:
            writer.add_mesh(target.name, primitives)

    def _filled(self, target, matrix, triangles, slots, material, shader, fluid):
        """A closed mesh as bounds of a medium, and its surfaces, if it has a surface shader."""
        name = owner("object", target)
        components = media.components_of(shader, self.report, owner("material", material))
        if fluid is not None:
            self.files += 1
            stem = os.path.join(self.folder, f"{self.prefix}gas_{self.files}")
            frame = round(self.scene.frame_current + self.scene.frame_subframe)
            self.media += volumes.media_of_fluid(target, matrix, fluid, components, frame, stem, self.report)
            return
        solid = _surface_of(material)
        box = meshes.box_of(triangles)
        if box is not None and solid is None:
            bounds = box
        else:
            bounds = {"file": self._bounds_file(target, triangles, slots, solid is not None, name)}
        extent = max(float((triangles.positions.max(0) - triangles.positions.min(0)).max()), 1e-9)
        domain = media.Domain(bounds, extent=extent)
        self.media += media.media_of(components, target.name, domain, self.report, name)

    def _bounds_file(self, target, triangles, slots, has_surface, name):
        self.files += 1
        file = f"{self.prefix}bounds_{self.files}.glb"
        gaps = meshes.open_edges(triangles)
        if gaps:
            self.report.approximate(name, f"a mesh with {gaps} open edges bounds a medium")
        if not meshes.faces_outwards(triangles):
            self.report.approximate(name, "a mesh whose faces point inwards bounds a medium: they are turned")
            triangles.positions = triangles.positions.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)
            triangles.normals = -triangles.normals.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)
            if triangles.uvs is not None:
                triangles.uvs = triangles.uvs.reshape(-1, 3, 2)[:, ::-1].reshape(-1, 2)
        writer = glb.Writer()
        if has_surface:
            self._add_surfaces(writer, materials.Materials(writer, self.report), target, triangles, slots)
            self.geometry.append({"file": file})
        else:
            writer.add_mesh(target.name, [meshes.primitive_of(triangles, triangles.slots >= 0, None, glb.y_up)])
        writer.write(os.path.join(self.folder, file))
        return file

    # ---- the world ----

    def _world(self):
        self.lights += world.environment_of(self.scene.world, self.folder, self.report)
        if self.scene.world is None or not self.scene.world.use_nodes or self.scene.world.node_tree is None:
            return
        place = output_of(self.scene.world.node_tree, "OUTPUT_WORLD", "Volume")
        if place is None:
            return
        name = owner("world", self.scene.world)
        components = media.components_of(place, self.report, name)
        box, margin = world.box_of_air(self.points or [(0, 0, 0)])
        air = media.media_of(components, "world", media.Domain(box, extent=2 * margin), self.report, name)
        self.media += air
        self.report.approximate(name, f"a medium without end: a box whose faces are {margin:.4g} m from the scene")
        if self.scene.camera is not None and self.scene.camera.data.type == "ORTHO":
            self.report.lose(name, "parallel rays within it: the camera sees it from too far away")
        if self._setting("distant_light", False):
            self.report.approximate(name, "light of the sun and the world comes in through that box, which it does not in Cycles")
            return
        arriving = world.arriving(self.lights, air)
        if arriving != self.lights:
            self.lights = arriving
            self.report.lose(name, "light of the sun and the world, which does not arrive through a medium without end, as in Cycles")

    # ---- the file ----

    def document(self):
        """The scene file as a dict; writes the GLB files."""
        camera = self.scene.camera
        for instance in self.depsgraph.object_instances:
            if instance.show_self and not instance.object.hide_render:
                self._visit(instance)
        out = {"tyndall": 1, "up_axis": "z"}
        if camera is not None:
            evaluated = camera.evaluated_get(self.depsgraph)
            self.points.append(tuple(evaluated.matrix_world.translation))
            out["camera"] = camera_of(evaluated, self.depsgraph, self.size, self.report)
        self._world()
        if len(self.writer):
            file = f"{self.prefix}surfaces.glb"
            self.writer.write(os.path.join(self.folder, file))
            self.geometry.insert(0, {"file": file})
        out.update({"media": self.media, "lights": self.lights, "geometry": self.geometry})
        return out


def _volume_of(material):
    if material is None or not material.use_nodes or material.node_tree is None:
        return None
    return output_of(material.node_tree, "OUTPUT_MATERIAL", "Volume")


def _surface_of(material):
    if not material.use_nodes or material.node_tree is None:
        return None
    return output_of(material.node_tree, "OUTPUT_MATERIAL", "Surface")


def write_scene(depsgraph, folder, name="scene.json", settings=None, poses=None, size=None, program=None, instants=1):
    """Writes folder/scene.json and report.txt. settings: the "render" of the scene file; poses: world matrices of the
    camera as the shutter opens and closes; instants: of the shutter's time, of which this is one. Returns the path of the scene
    file and the Report."""
    os.makedirs(folder, exist_ok=True)
    export = Export(depsgraph, folder, program, size)
    document = export.document()
    if poses is not None and "camera" in document:
        add_motion(document["camera"], *poses)
        if instants == 1:
            export.report.lose("scene", "motion blur of all but the camera")
    if instants > 1:
        export.report.approximate("scene", f"motion of objects: {instants} instants")
    if settings:
        document["render"] = settings
    if len(export.report):
        document["comment"] = ["exported from Blender; left out or approximated:", *export.report.lines()]
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file, indent=1, ensure_ascii=False)
    with open(os.path.join(folder, "report.txt"), "w", encoding="utf-8") as file:
        file.write(export.report.text())
    return path, export.report
