#!/usr/bin/env python3
"""Writes scenes/builtin/atrium.json: an open court of 18 m by 6 m in two storeys of arches, galleries around it, 24 m by
12 m in all, in fog, with a sun that falls through the open roof. usage: scripts/make_atrium.py > scenes/builtin/atrium.json

Arches are rings of boxes, turned, under straight walls. Lengths in m; y is up, x along the court."""
import math

STONE, PALE, FLOOR, WALL, ROOF = [0.62, 0.56, 0.47], [0.7, 0.66, 0.6], [0.45, 0.42, 0.4], [0.6, 0.5, 0.38], [0.5, 0.33, 0.25]
RED, BLUE, GREEN = [0.62, 0.07, 0.05], [0.06, 0.14, 0.5], [0.1, 0.4, 0.12]
BAY = 3.0  # between the middles of columns
RADIUS = 1.25  # of arches
RING = 0.3  # how thick these are
STONES = 7  # boxes of an arch
DEPTH = 0.25  # half of what walls on columns are thick
COURT = (9.0, 3.0)  # half of it along x and z
OUTER = (12.0, 6.0)  # half of all of it
# Each storey: its floor, where arches begin, its ceiling, how thick that is.
STOREYS = ((0.0, 3.3, 5.0, 0.3), (5.3, 8.6, 10.5, 0.4))
FOG_TOP = 12.0

shapes = []


def number(value):
    return f"{round(value, 2) + 0.0:g}"


def vector(values):
    return "[" + ", ".join(number(v) for v in values) + "]"


def material(albedo):
    return f'"material": {{ "albedo": {vector(albedo)} }}'


def box(lower, upper, albedo, transform=""):
    shapes.append(f'{{ "box": [{vector(lower)}, {vector(upper)}], {transform}{material(albedo)} }}')


def quad(origin, u, v, albedo):
    shapes.append(f'{{ "quad": {{ "origin": {vector(origin)}, "u": {vector(u)}, "v": {vector(v)} }}, {material(albedo)} }}')


def upright(x, z, half, bottom, top, albedo):
    box((x - half, bottom, z - half), (x + half, top, z + half), albedo)


def column(x, z, floor, spring):
    upright(x, z, 0.21, floor, spring - 0.25, STONE)
    upright(x, z, 0.3, spring - 0.25, spring, PALE)


def arch(x, z, along_x, spring):
    """Turned about where it begins, each stone between RADIUS and RADIUS + RING."""
    half = (RADIUS + RING) * math.tan(math.pi / 2 / STONES)
    for i in range(STONES):
        angle = 180 * (i + 0.5) / STONES
        depth = DEPTH + 0.02
        lower, upper = (RADIUS, -half, -depth), (RADIUS + RING, half, depth)
        rotate = (0, 0, angle)
        if not along_x:
            lower, upper, rotate = (-depth, -half, RADIUS), (depth, half, RADIUS + RING), (-angle, 0, 0)
        box(lower, upper, PALE, f'"transform": {{ "rotate": {vector(rotate)}, "translate": {vector((x, spring, z))} }}, ')


def above_column(x, z, along_x, spring):
    """The wall between two arches, in two steps that their rings hide."""
    for half, rise in ((0.3, 0.35), (0.65, 0.92)):
        a, b = (half, DEPTH) if along_x else (DEPTH, half)
        box((x - a, spring + rise, z - b), (x + a, spring + RADIUS, z + b), STONE)


def arcade(side, along_x, floor, spring, ceiling):
    """One side of the court."""
    length, across = COURT if along_x else COURT[::-1]
    bays = round(2 * length / BAY)
    def place(t):
        return (t, side * across) if along_x else (side * across, t)
    for i in range(bays + 1):
        x, z = place(-length + BAY * i)
        if along_x or 0 < i < bays:
            column(x, z, floor, spring)
        above_column(x, z, along_x, spring)
    for i in range(bays):
        arch(*place(-length + BAY * (i + 0.5)), along_x, spring)
    x, z = place(length)
    a, b = (length, DEPTH) if along_x else (DEPTH, length)
    middle = (0, z) if along_x else (x, 0)
    box((middle[0] - a, spring + RADIUS, middle[1] - b), (middle[0] + a, ceiling, middle[1] + b), STONE)
    if floor > 0:  # a parapet
        c, d = (length, 0.1) if along_x else (0.1, length)
        box((middle[0] - c, floor, middle[1] - d), (middle[0] + c, floor + 0.9, middle[1] + d), PALE)


def around_court(bottom, top, albedo):
    """A slab over the galleries."""
    x, z, outer_x, outer_z = COURT[0] + DEPTH, COURT[1] + DEPTH, *OUTER
    x, z = x - 2 * DEPTH, z - 2 * DEPTH  # as far as the court's side of the walls
    for side in (-1, 1):
        ends = sorted((side * z, side * outer_z))
        box((-outer_x, bottom, ends[0]), (outer_x, top, ends[1]), albedo)
        ends = sorted((side * x, side * outer_x))
        box((ends[0], bottom, -z), (ends[1], top, z), albedo)


def hanging(x, z, floor, spring, albedo, across=0):
    """Cloth in an arch, from its beginning to a third of its height."""
    bottom, top = floor + 0.35 * (spring - floor), spring + 0.35
    quad((x - 0.95, bottom, z + across), (1.9, 0, 0), (0, top - bottom, 0), albedo)


def build():
    (low_floor, _, _, _), (_, _, roof, roof_thick) = STOREYS
    box((-OUTER[0], -0.4, -OUTER[1]), (OUTER[0], low_floor, OUTER[1]), FLOOR)
    for side in (-1, 1):
        for axis in (0, 1):
            near, far = sorted((side * OUTER[axis], side * (OUTER[axis] + 0.4)))
            other = OUTER[1 - axis] + (0.4 if axis == 0 else 0)
            lower, upper = [(near, -0.4, -other), (far, roof + roof_thick, other)]
            if axis == 1:
                lower, upper = (lower[2], lower[1], lower[0]), (upper[2], upper[1], upper[0])
            box(lower, upper, WALL)
    for floor, spring, ceiling, thick in STOREYS:
        for side in (-1, 1):
            arcade(side, True, floor, spring, ceiling)
            arcade(side, False, floor, spring, ceiling)
        around_court(ceiling, ceiling + thick, ROOF if ceiling == roof else PALE)
    for storey, x, side, albedo in ((0, -4.5, -1, RED), (0, 1.5, -1, GREEN), (0, 7.5, 1, BLUE), (0, -1.5, 1, RED),
                                    (1, -1.5, -1, BLUE), (1, 4.5, 1, GREEN), (1, 4.5, -1, RED), (1, -7.5, 1, BLUE)):
        hanging(x, side * COURT[1], STOREYS[storey][0], STOREYS[storey][1], albedo)
    upright(2.5, 0, 0.8, 0, 0.6, PALE)
    shapes.append(f'{{ "sphere": {{ "center": [2.5, 1.3, 0], "radius": 0.7 }}, {material((0.75, 0.72, 0.66))} }}')


def write():
    fog = f"[[{-OUTER[0]:g}, 0, {-OUTER[1]:g}], [{OUTER[0]:g}, {FOG_TOP:g}, {OUTER[1]:g}]]"
    print('{\n  "tyndall": 1,')
    print('  "camera": { "position": [-8.3, 1.8, -1.6], "target": [0.5, 3.4, 2.4], "fov_y": 66, "resolution": [960, 540], '
          '"exposure": 0 },')
    print(f'  "media": [{{ "name": "fog", "bounds": {fog}, "sigma_s": 0.05, "sigma_a": 0, "g": 0.5 }}],')
    print('  "lights": [{ "type": "directional", "direction": [0.3, -1, 0.4], "irradiance": [20, 18.5, 16] }],')
    print('  "geometry": [')
    print(",\n".join("  " + shape for shape in shapes))
    print('  ],\n  "render": { "method": "lpv", "spp": 128, "lpv": { "resolution": 48 } }\n}')


build()
write()
