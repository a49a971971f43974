#!/usr/bin/env bash
# tyndall render and compare by dom from outside: options, channels, surfaces, messages, interrupts.
# usage: test_cli_dom.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.dom.resolution=8 -D render.dom.direct=16 -q'

# dom SCENE OUT ARGUMENT...: a small image by dom.
dom() {
  small_by dom "$@"
}

test_scenes_name_the_method() {
  named_by_scenes dom '{"resolution": 8, "direct": 16}'
}

# Every key changes what it should, or nothing at all.
test_options() {
  changed_by dom fog.json resolution=12 direct=20 directions=48 bands=2 tolerance=0.3 iterations=1 environment_beams=7 \
    spp=4 step=0.3 acceleration=none last_directions=48
  kept_by dom fog.json resolution=8 direct=16 directions=96 bands=auto tolerance=1e-3 iterations=auto iterations=100 \
    environment_beams=64 surface_points=3 last_directions=0 spp=1 step=1 acceleration=diffusion
  dom fog.json seeded.exr --seed 3
  different plain.exr seeded.exr
}

test_wrong_options() {
  refused_options dom << 'END'
direction=48 did you mean .*directions
directions=7 render.dom.directions
directions=1025 render.dom.directions
last_directions=7 dom.last_directions: 7 is outside \[8, 1024\]
last_directions=1025 render.dom.last_directions
resolution=1025 render.dom.resolution
resolution=3 dom.resolution: 3 is outside \[4, 1024\]
direct=1025 render.dom.direct
direct=3 dom.direct: 3 is outside \[4, 1024\]
bands=13 render.dom.bands
tolerance=0 render.dom.tolerance
tolerance=1 render.dom.tolerance
iterations=-1 render.dom.iterations
acceleration=difusion did you mean .*diffusion
environment_beams=0 render.dom.environment_beams
surface_points=0 render.dom.surface_points
spp=65 render.dom.spp
step=9 render.dom.step
END
}

test_channels() {
  channels dom single,multiple,transmittance,depth 'single.R multiple.B transmittance.G depth.Z' 'normal albedo'
}

test_surfaces() {
  surfaces_by_paths dom
}

test_statistics() {
  dom fog.json out.exr --stats stats.json
  statistics dom 'direct_size size sweeps cycles change emitted absorbed leaving' \
    'medium_seconds direct_seconds source_seconds solve_seconds sweep_seconds march_seconds bytes'
  said stats.json '"converged": true'
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr --method dom ${small% -q}
  said out.txt '16x16x16 cells of direct light, 8x8x8 of 96 ordinates, [0-9]+ sweeps, '
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr --method dom ${small% -q} -D render.dom.iterations=1 -D render.dom.tolerance=1e-9
  said out.txt 'sweeps, not converged'
}

test_compare() {
  compares 'path dom'
}

test_scenes_without_media() {
  needs_media dom dom
}

test_interrupt() {
  for resolution in 128 8; do
    interrupted builtin:cloud_sky --method dom -D render.dom.spp=16 -D render.dom.resolution=$resolution \
      -D render.dom.directions=1024
  done
}

write_scenes '{"type": "point", "position": [0, 1.5, 0], "intensity": 3}'

run_tests 180
