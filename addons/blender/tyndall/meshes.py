"""Triangles of Blender's objects in world space."""
import numpy as np


class Triangles:
    """positions, normals, uvs: by corner of a triangle; slots: material slot of each triangle."""

    def __init__(self, positions, normals, uvs, slots):
        self.positions, self.normals, self.uvs, self.slots = positions, normals, uvs, slots


def _get(collection, attribute, width, kind):
    out = np.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, out)
    return out.reshape(-1, width) if width > 1 else out


def triangles_of(instance_object, matrix):
    """The Triangles of an evaluated object placed by a world matrix; None without any."""
    mesh = instance_object.to_mesh()
    if mesh is None:
        return None
    try:
        return _triangles(mesh, np.array(matrix, np.float64))
    finally:
        instance_object.to_mesh_clear()


def _triangles(mesh, matrix):
    if hasattr(mesh, "calc_normals_split"):  # until Blender 4.0; later versions have the normals of corners at hand
        mesh.calc_normals_split()
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return None
    vertices = _get(mesh.vertices, "co", 3, np.float32).astype(np.float64)
    corners = _get(mesh.loop_triangles, "loops", 3, np.int32)
    of_corner = _get(mesh.loops, "vertex_index", 1, np.int32)
    normals = _get(mesh.loops, "normal", 3, np.float32).astype(np.float64)
    slots = _get(mesh.loop_triangles, "material_index", 1, np.int32)
    positions = (vertices @ matrix[:3, :3].T + matrix[:3, 3])[of_corner[corners.ravel()]]
    linear = matrix[:3, :3]
    if abs(np.linalg.det(linear)) > 1e-30:
        normals = normals @ np.linalg.inv(linear)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = (normals / np.where(length > 0, length, 1))[corners.ravel()]
    uvs = None
    if mesh.uv_layers.active is not None:
        uvs = _get(mesh.uv_layers.active.data, "uv", 2, np.float32)[corners.ravel()]
        uvs = np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1)
    if np.linalg.det(linear) < 0:
        flip = np.arange(len(positions)).reshape(-1, 3)[:, ::-1].ravel()
        positions, normals = positions[flip], normals[flip]
        uvs = uvs[flip] if uvs is not None else None
    return Triangles(positions, normals, uvs, slots)


def primitive_of(triangles, chosen, material, y_up):
    """A primitive of glb.Writer.add_mesh of the chosen triangles (booleans); equal corners are joined."""
    corners = np.repeat(chosen, 3)
    columns = [y_up(triangles.positions[corners]), y_up(triangles.normals[corners])]
    if triangles.uvs is not None:
        columns.append(triangles.uvs[corners].astype(np.float32))
    joined = np.ascontiguousarray(np.concatenate(columns, axis=1).astype(np.float32)) + np.float32(0)
    rows, indices = np.unique(joined, axis=0, return_inverse=True)
    return {"positions": rows[:, :3], "normals": rows[:, 3:6], "uvs": rows[:, 6:8] if triangles.uvs is not None else None,
            "triangles": indices.reshape(-1, 3), "material": material}


def open_edges(triangles):
    """The number of edges that do not belong to two triangles."""
    keys = np.round(triangles.positions.astype(np.float32), 6) + np.float32(0)
    _, index = np.unique(keys, axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    edges = np.sort(np.concatenate([index[:, [0, 1]], index[:, [1, 2]], index[:, [2, 0]]]), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, counts = np.unique(edges, axis=0, return_counts=True)
    return int((counts % 2 != 0).sum())


def faces_outwards(triangles):
    """True where the volume that the triangles enclose is positive."""
    a, b, c = (triangles.positions.reshape(-1, 3, 3)[:, i] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) > 0


def box_of(triangles):
    """Lower and upper corner where the triangles are a box along the axes; None otherwise."""
    lower, upper = triangles.positions.min(0), triangles.positions.max(0)
    tolerance = 1e-5 * max(float((upper - lower).max()), 1e-30)
    at_face = np.minimum(np.abs(triangles.positions - lower), np.abs(triangles.positions - upper)).max()
    if len(triangles.slots) != 12 or at_face > tolerance or (upper - lower).min() <= tolerance:
        return None
    return [lower.tolist(), upper.tolist()]
