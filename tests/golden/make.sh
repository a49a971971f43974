#!/usr/bin/env bash
# Renders the images that truth_golden holds path tracing against: 16 x 16 pixels of scenes that are built in, means and
# variances of the means, a few kB each. Made anew only when a scene changes, or when an error in the path tracer is
# mended: 16384 samples a pixel take about two minutes of one core in all.
# usage: tests/golden/make.sh build/release/bin/tyndall
set -euo pipefail
tyndall=$(realpath "$1")
cd "$(dirname "$0")"
for scene in cube_g0.7 cornell_fog fog_cornell nebulae lamps cloud_sky; do
  "$tyndall" render "builtin:$scene" --method path --size 16x16 --spp 16384 --seed 20260101 --aov variance \
    -o "$scene.exr" -q
done
