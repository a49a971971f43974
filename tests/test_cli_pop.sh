#!/usr/bin/env bash
# tyndall render and compare by pop from outside: options, modes, channels, surfaces, messages, interrupts.
# usage: test_cli_pop.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.pop.resolution=8 -D render.pop.ordinates=8 -q'

# pop SCENE OUT ARGUMENT...: a small image, by pop.
pop() {
  small_by pop "$@"
}

test_scenes_name_the_method() {
  named_by_scenes pop '{"resolution": 8, "ordinates": 8}'
}

# Every key changes what it should, or nothing at all.
test_options() {
  changed_by pop fog.json mode=published mode=collided resolution=10 merged=8 fine_lights=false direct=8 ordinates=5 \
    prefilter=0 importance=false max_flux_fraction=1 spp=4 step=0.3
  kept_by pop fog.json mode=split merged=12 tolerance=1e-2 fine_lights=true direct=64 prefilter=1 importance=true \
    surface_points=9 vpls=9 vpl_min_distance=0.2 shadow_texels=64 iterations=3 residuum=0.5 residuum_iterations=2 max_flux_fraction=auto \
    spp=1 step=1
  pop fog.json seeded.exr --seed 3
  different plain.exr seeded.exr
}

# What the paper's modes alone heed, and what the diffusion alone heeds.
test_modes() {
  for mode in published collided; do
    pop fog.json propagated.exr -D render.pop.mode=$mode
    for option in iterations=2 residuum=0 residuum_iterations=1; do
      pop fog.json other.exr -D render.pop.mode=$mode -D "render.pop.$option"
      different propagated.exr other.exr
    done
    for option in max_flux_fraction=1 tolerance=1e-2 fine_lights=false direct=8; do
      pop fog.json other.exr -D render.pop.mode=$mode -D "render.pop.$option"
      same propagated.exr other.exr
    done
  done
  pop fog.json published.exr -D render.pop.mode=published
  pop fog.json collided.exr -D render.pop.mode=collided
  different published.exr collided.exr
}

# Surfaces come from paths, and light the medium.
test_surfaces() {
  surfaces_by_paths pop
  for option in surface_points=2 max_flux_fraction=0.3; do
    pop room.json other.exr --spp 1 -D "render.pop.$option"
    different few.exr other.exr
  done
  pop room.json published.exr --spp 1 -D render.pop.mode=published
  for option in vpls=0 vpls=9 shadow_texels=16 vpl_min_distance=0.5; do
    pop room.json other.exr --spp 1 -D render.pop.mode=published -D "render.pop.$option"
    different published.exr other.exr
    pop room.json other.exr --spp 1 -D "render.pop.$option"
    same few.exr other.exr
  done
}

test_wrong_options() {
  refused_options pop << 'END'
mod=split did you mean .*mode
mode=splitt did you mean .*split
resolution=3 pop.resolution: 3 is outside \[4, 128\]
resolution=129 render.pop.resolution
merged=3 pop.merged: 3 is outside \[4, 512\]
merged=513 render.pop.merged
direct=3 pop.direct: 3 is outside \[4, 1024\]
direct=1025 render.pop.direct
fine_lights=1 render.pop.fine_lights
ordinates=0 render.pop.ordinates
ordinates=4097 render.pop.ordinates
prefilter=-1 render.pop.prefilter
prefilter=17 render.pop.prefilter
importance=2 render.pop.importance
surface_points=0 render.pop.surface_points
vpls=4097 render.pop.vpls
shadow_texels=8 render.pop.shadow_texels
vpl_min_distance=2 render.pop.vpl_min_distance
iterations=-1 render.pop.iterations
residuum=2 render.pop.residuum
residuum_iterations=10001 render.pop.residuum_iterations
max_flux_fraction=-1 render.pop.max_flux_fraction
tolerance=1 render.pop.tolerance
spp=65 render.pop.spp
step=9 render.pop.step
END
}

test_channels() {
  channels pop single,multiple,transmittance,depth 'single.R multiple.B transmittance.G depth.Z' 'normal albedo'
}

test_statistics() {
  for mode in split published; do
    pop room.json out.exr --stats stats.json -D render.pop.mode=$mode
    statistics pop 'size merged_size' 'ordinates vpls planes iterations residuum_iterations left bytes medium_seconds
      importance_seconds ordinate_seconds vpl_seconds direct_seconds initial_seconds propagation_seconds
      residuum_seconds merge_seconds march_seconds'
    said stats.json '"converged": true'
  done
  said stats.json '"vpls": [1-9]'
  expect 0 render fog.json -o out.exr --method pop --size 24x16 -D render.pop.resolution=8 -D render.pop.ordinates=9
  said out.txt '9 ordinates of 8x8x16 cells, 12x12x12 merged, '
  unsaid out.txt '^surfaces'
  expect 0 render room.json -o out.exr --method pop --size 24x16 -D render.pop.resolution=8 --spp 2
  said out.txt '^surfaces: 2 spp of path'
  expect 0 render fog.json -o out.exr --method pop --size 24x16 -D render.pop.mode=published \
    -D render.pop.resolution=8 -D render.pop.residuum_iterations=1
  said out.txt 'not converged'
}

test_compare() {
  compares 'path fld pop' -D render.pop.resolution=8
}

test_scenes_without_media() {
  needs_media pop pop
}

test_interrupt() {
  for mode in split published; do
    interrupted builtin:cloud_sky --method pop -D render.pop.spp=16 -D render.pop.resolution=48 \
      -D render.pop.ordinates=512 -D render.pop.mode=$mode
  done
}

write_scenes '{"type": "point", "position": [0, 1.5, 0], "intensity": 3},
    {"type": "area", "origin": [-0.5, 2, -0.5], "u": [1, 0, 0], "v": [0, 0, 1], "radiance": 1}'

run_tests 180
