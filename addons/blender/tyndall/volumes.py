"""Media of volume objects, from OpenVDB files as they are, and of fluid domains, from the frames of their caches."""
import os

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import media, process
from .nodes import output_of
from .report import owner


def _rows(matrix):
    return [v for row in matrix for v in row]


# ---- volume objects ----

def media_of_volume(target, matrix, program, report):
    """Entries of "media" for an evaluated volume object. program: of Tyndall, which tells maxima of grids; None: unknown."""
    volume, name = target.data, owner("volume", target)
    grids = volume.grids
    if not grids.is_loaded and not grids.load():
        report.lose(name, f"its file: {grids.error_message or 'it cannot be read'}")
        return []
    path = os.path.abspath(bpy.path.abspath(grids.frame_filepath or volume.filepath, library=volume.library))
    if not os.path.isfile(path):
        report.lose(name, f"its file, which is not there: {path}")
        return []
    if any(m.type != "VOLUME_DISPLACE" and m.show_render for m in target.modifiers) or len(target.modifiers):
        report.lose(name, "its modifiers")
    known = {g.name: {"file": path, "grid": g.name} for g in grids if "VECTOR" not in g.data_type and g.data_type != "MASK"}
    components = _components(target, report, name)
    corners = [matrix @ Vector(c) for c in target.bound_box]
    extent = max(max(c[a] for c in corners) - min(c[a] for c in corners) for a in range(3)) or 1.0
    factor = 1.0
    if volume.render.space == "OBJECT":
        # Cycles keeps the optical thickness of a scaled object: densities over the length of a scaled unit vector.
        factor = 1 / max((matrix.to_3x3() @ Vector((1, 1, 1)).normalized()).length, 1e-30)
    domain = media.Domain(None, _rows(matrix), known, extent, factor,
                          lambda grid: process.maximum_of_grid(program, path, grid) if program else None)
    return media.media_of(components, target.name, domain, report, name)


def _components(target, report, name):
    """The components of the first material, or of Principled Volume as it is without one."""
    material = next((s.material for s in target.material_slots if s.material is not None), None)
    if material is None:
        body = media.Component((0.5,) * 3, (0.5,) * 3)
        body.optional_grid = "density"
        return [body]
    if not material.use_nodes or material.node_tree is None:
        report.lose(name, "a material without nodes")
        return []
    place = output_of(material.node_tree, "OUTPUT_MATERIAL", "Volume")
    if place is None:
        report.lose(name, "a material without a volume shader")
    return media.components_of(place, report, owner("material", material))


# ---- fluid domains ----

def domain_of_fluid(target):
    """The settings of a domain of gas, or None."""
    for modifier in target.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            settings = modifier.domain_settings
            if settings is not None and settings.domain_type == "GAS":
                return settings
    return None


def _cache_file(settings, frame):
    folder = bpy.path.abspath(settings.cache_directory)
    return os.path.join(folder, "data", f"fluid_data_{frame:04d}.vdb")


def _uses_temperature(component):
    """True for a component of the grid that Blender makes of flames: no cache has it."""
    names = (getattr(component.density, "name", ""), getattr(component.emits, "name", ""))
    return component.black_body is not None or "temperature" in names


def media_of_fluid(target, matrix, settings, components, frame, stem, report):
    """Entries of "media" for a domain of gas: its cache as OpenVDB where it is one of whole cells, else its grids as raw
    files, whose names begin with the path `stem`, and so always its temperature."""
    name = owner("object", target)
    path = _cache_file(settings, frame)
    extent = max((matrix.to_3x3() @ Vector(c)).length for c in ((2, 0, 0), (0, 2, 0), (0, 0, 2)))
    values = {"density": settings.density_grid, "flame": settings.flame_grid, "temperature": settings.temperature_grid}
    if len(values["density"]) == 0:
        report.lose(name, "its gas, of which this frame has none")
        return []
    as_file = settings.cache_data_format == "OPENVDB" and os.path.isfile(path) and not settings.use_noise \
        and not settings.use_adaptive_domain
    of_cache = [c for c in components if as_file and not _uses_temperature(c)]
    others = [c for c in components if c not in of_cache]
    out = []
    if of_cache:
        domain = _cache_domain(matrix, values, settings, path, extent)
        out += media.media_of(of_cache, target.name, domain, report, name)
    if others:
        domain = _raw_domain(matrix, values, settings, extent, stem, report, name)
        out += media.media_of(others, target.name, domain, report, name)
    return out


def _cache_domain(matrix, values, settings, path, extent):
    cell = Vector(settings.cell_size)
    voxel = [cell[a] * matrix.col[a].xyz.length for a in range(3)]
    # The cache has the centre of cell i at i voxels; the domain has it at start + (i + 1/2) cells.
    place = matrix @ Matrix.Translation(Vector(settings.start_point) + cell / 2)
    place = place @ Matrix.Diagonal([cell[a] / voxel[a] for a in range(3)] + [1])
    grids = {n: {"file": os.path.abspath(path), "grid": n} for n, v in values.items() if len(v) and n != "temperature"}
    return media.Domain(None, _rows(place), grids, extent)


def _raw_domain(matrix, values_of, settings, extent, stem, report, name):
    size = list(settings.domain_resolution)
    grids, maxima = {}, {}
    for grid, values in values_of.items():
        count = len(values)
        if count == 0:
            continue
        factor = round((count / (size[0] * size[1] * size[2])) ** (1 / 3))
        fine = [s * factor for s in size]
        if fine[0] * fine[1] * fine[2] != count:
            report.lose(name, f"grid {grid}, which has {count} values")
            continue
        data = np.empty(count, np.float32)
        values.foreach_get(data)
        maxima[grid] = float(data.max(initial=0))
        data.tofile(f"{stem}_{grid}.raw")
        grids[grid] = {"file": f"{os.path.basename(stem)}_{grid}.raw", "raw": {"size": fine, "type": "float"}}
    start, cell = Vector(settings.start_point), Vector(settings.cell_size)
    upper = [start[a] + cell[a] * size[a] for a in range(3)]
    return media.Domain([list(start), upper], _rows(matrix), grids, extent, maximum_of=maxima.get)
