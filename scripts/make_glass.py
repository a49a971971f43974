#!/usr/bin/env python3
"""Writes scenes/milk_glass.obj and scenes/milk.obj: a tumbler and the milk in it, as surfaces of revolution.

The milk reaches a fifth of a millimetre into the glass, whose priority is above its own."""
import math
import os

SEGMENTS = 48
FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "scenes")


def arc(center, radius, start, end, steps):
    """Points of a rounded edge in the half plane (r, y), angles in degrees from +r."""
    angles = [math.radians(start + (end - start) * i / steps) for i in range(steps + 1)]
    return [(center[0] + radius * math.cos(a), center[1] + radius * math.sin(a)) for a in angles]


def revolve(profile):
    """Vertices and faces of a profile from axis to axis, counter-clockwise seen from outside."""
    vertices = [(0, profile[0][1], 0)]
    rings = profile[1:-1]
    for r, y in rings:
        for k in range(SEGMENTS):
            turn = 2 * math.pi * k / SEGMENTS
            vertices.append((r * math.cos(turn), y, -r * math.sin(turn)))
    vertices.append((0, profile[-1][1], 0))
    faces = []
    for k in range(SEGMENTS):
        n = (k + 1) % SEGMENTS
        faces.append((0, 1 + n, 1 + k))
        for j in range(len(rings) - 1):
            a, b = 1 + j * SEGMENTS, 1 + (j + 1) * SEGMENTS
            faces.append((a + k, a + n, b + n))
            faces.append((a + k, b + n, b + k))
        last = 1 + (len(rings) - 1) * SEGMENTS
        faces.append((last + k, last + n, len(vertices) - 1))
    return vertices, faces


def normals(vertices, faces):
    """Unit normals at vertices, means of the triangles' weighted by angle."""
    sums = [[0.0] * 3 for _ in vertices]
    for face in faces:
        for i in range(3):
            p, q, r = (vertices[face[(i + j) % 3]] for j in range(3))
            u = [q[a] - p[a] for a in range(3)]
            v = [r[a] - p[a] for a in range(3)]
            cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            length = math.hypot(*cross)
            angle = math.atan2(length, sum(x * y for x, y in zip(u, v)))
            for a in range(3):
                sums[face[i]][a] += angle * cross[a] / length
    return [[x / math.hypot(*n) for x in n] for n in sums]


def write(name, profile):
    vertices, faces = revolve(profile)
    with open(os.path.join(FOLDER, name), "w", encoding="ascii") as out:
        out.write("# written by scripts/make_glass.py\n")
        for v in vertices:
            out.write("v %.6f %.6f %.6f\n" % v)
        for n in normals(vertices, faces):
            out.write("vn %.4f %.4f %.4f\n" % tuple(n))
        for face in faces:
            out.write("f " + " ".join("%d//%d" % (i + 1, i + 1) for i in face) + "\n")


def main():
    outer, inner, height, base, fill = 0.035, 0.032, 0.11, 0.008, 0.08
    rim, overlap = (outer - inner) / 2, 0.0002
    glass = [(0, 0), (0.02, 0), (0.03, 0)] + arc((outer - 0.003, 0.003), 0.003, -90, 0, 6)
    glass += [(outer, 0.02), (outer, 0.05), (outer, 0.08)] + arc((outer - rim, height - rim), rim, 0, 180, 10)
    glass += [(inner, 0.08), (inner, 0.05), (inner, 0.02)]
    glass += [(r, y) for r, y in arc((inner - 0.004, base + 0.004), 0.004, 0, -90, 6)]
    glass += [(0.014, base), (0, base)]
    wide = inner + overlap
    milk = [(0, base - overlap), (0.014, base - overlap)]
    milk += arc((wide - 0.004, base - overlap + 0.004), 0.004, -90, 0, 6)
    milk += [(wide, 0.03), (wide, 0.05), (wide, fill - 0.002), (wide, fill), (wide - 0.0005, fill)]
    milk += [(0.02, fill), (0.01, fill), (0, fill)]
    write("milk_glass.obj", glass)
    write("milk.obj", milk)


if __name__ == "__main__":
    main()
