#!/usr/bin/env bash
# tyndall render and compare by fld and cda from outside: options, channels, surfaces, messages, interrupts.
# usage: test_cli_fld.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.fld.resolution=16 -q'

# fld SCENE OUT ARGUMENT...: a small image, by fld unless told otherwise.
fld() {
  small_by fld "$@"
}

test_scenes_name_the_method() {
  named_by_scenes fld '{"resolution": 16}'
}

# cda is fld without a limiter, whatever the scene says of limiters.
test_classical_diffusion() {
  fld fog.json fld.exr
  fld fog.json none.exr -D render.fld.limiter=none
  fld fog.json cda.exr --method cda
  fld fog.json kershaw.exr --method cda -D render.fld.limiter=kershaw
  same cda.exr none.exr
  same cda.exr kershaw.exr
  different cda.exr fld.exr
}

# Every key changes what it should, or nothing at all.
test_options() {
  changed_by fld fog.json limiter=sum limiter=max limiter=kershaw limiter=larsen max_flux_fraction=1 boundary=dirichlet \
    beam=published resolution=12 ratio=1 environment_beams=7 spp=4 step=0.3 solver=sor iterations=1 sigma_eps=5
  kept_by fld fog.json limiter=levermore_pomraning max_flux_fraction=auto boundary=marshak solver=multigrid beam=reduced ratio=2 \
    environment_beams=64 surface_points=16 spp=1 step=1 larsen_power=3 relaxation=1 iterations=auto sigma_eps=auto
  fld fog.json power.exr -D render.fld.limiter=larsen -D render.fld.larsen_power=5
  fld fog.json other.exr -D render.fld.limiter=larsen
  different power.exr other.exr
  fld fog.json seeded.exr --seed 3
  different plain.exr seeded.exr
}

test_wrong_options() {
  refused_options fld << 'END'
limitter=sum did you mean .*limiter
limiter=kershow did you mean .*kershaw
resolution=2000 render.fld.resolution
resolution=3 fld.resolution: 3 is outside \[4, 1024\]
resolution=-1 render.fld.resolution
resolution=0 render.fld.resolution: 0 is outside .4, 1024.; write "auto" for the default choice
ratio=0.5 fld.ratio: 0.5 is outside \[1, 64\]
ratio=65 render.fld.ratio
max_flux_fraction=-1 render.fld.max_flux_fraction
max_flux_fraction=2 render.fld.max_flux_fraction
relaxation=2 render.fld.relaxation
tolerance=1 render.fld.tolerance
larsen_power=0 render.fld.larsen_power
solver=multigird did you mean .*multigrid
boundary=0 render.fld.boundary
spp=65 render.fld.spp
step=9 render.fld.step
surface_points=0 render.fld.surface_points
END
  usage_error "unknown method 'fdl'.*path, screen, fld, cda, pop, lpv, dom" render fog.json -o no.exr --method fdl
}

test_channels() {
  channels fld single,multiple,transmittance,depth 'single.R multiple.B transmittance.G depth.Z' 'normal albedo'
  for aov in normal albedo; do
    usage_error "--aov: the method cda has no '$aov'" render fog.json -o no.exr --method cda --aov single,$aov
  done
}

test_surfaces() {
  surfaces_by_paths fld
}

test_statistics() {
  fld fog.json out.exr --stats stats.json
  statistics fld 'direct_size diffusion_size iterations cycles work residual emitted absorbed leaving' \
    'medium_seconds direct_seconds solve_seconds march_seconds bytes'
  said stats.json '"converged": true'
  expect 0 render fog.json -o out.exr --method fld --size 24x16 -D render.fld.resolution=16
  said out.txt '16x16x16 cells of direct light, 8x8x8 of diffusion'
  expect 0 render fog.json -o out.exr --method fld --size 24x16 -D render.fld.iterations=1 -D render.fld.tolerance=1e-9
  said out.txt 'not converged'
}

test_compare() {
  compares 'path fld cda'
}

test_scenes_without_media() {
  needs_media fld fld
  needs_media cda fld
}

test_interrupt() {
  for resolution in 200 16; do
    interrupted builtin:cloud_sky --method fld -D render.fld.spp=16 -D render.fld.resolution=$resolution \
      -D render.fld.environment_beams=2000
  done
}

write_scenes '{"type": "point", "position": [0, 1.5, 0], "intensity": 3}'

run_tests 180
