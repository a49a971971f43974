#!/usr/bin/env python3
"""Writes scenes/tools/path_emitters.json: a plain with 1000 small glowing spheres above it in haze.
usage: scripts/make_emitters.py > scenes/tools/path_emitters.json

Positions are those of a lattice of 10 x 10 x 10 cells, jittered. Lengths in m; y is up."""
import random

SIDE = 10
random.seed(1)


def number(value):
    return f"{round(value, 2) + 0.0:g}"


def vector(values):
    return "[" + ", ".join(number(v) for v in values) + "]"


print("""{
  "tyndall": 1,
  "camera": {"position": [0, 2.2, 11], "target": [0, 1.8, 0], "fov_y": 45, "resolution": [160, 120], "exposure": 1},
  "media": [{"name": "haze", "bounds": [[-6, 0, -6], [6, 5, 6]], "sigma_s": 0.1, "sigma_a": 0.005, "g": 0.6}],
  "geometry": [
    {"quad": {"origin": [-12, 0, 12], "u": [24, 0, 0], "v": [0, 0, -24]}, "material": {"albedo": 0.5}},""")
spheres = []
for i in range(SIDE ** 3):
    cell = i % SIDE, i // SIDE % SIDE, i // SIDE ** 2
    x, y, z = ((c + random.random()) / SIDE for c in cell)
    center = vector([10 * x - 5, 0.2 + 4.4 * y, 10 * z - 5])
    color = vector([random.uniform(2, 40) for _ in range(3)])
    spheres.append(f'    {{"sphere": {{"center": {center}, "radius": 0.03}}, "material": {{"albedo": 0, "emission": {color}}}}}')
print(",\n".join(spheres))
print("""  ],
  "render": {"method": "path"}
}""")
