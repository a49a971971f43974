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
  fld fog.json asked.exr
  expect 0 render fog.json -o named.exr --size 24x16 -D 'render={"method": "fld", "fld": {"resolution": 16}}' -q
  same asked.exr named.exr
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o again.exr $small --method fld --threads 1
  same asked.exr again.exr
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
  fld fog.json plain.exr
  for option in limiter=sum limiter=max limiter=kershaw limiter=larsen streaming=1 boundary=dirichlet beam=published \
    resolution=12 ratio=1 environment_beams=7 spp=4 step=0.3 solver=sor iterations=1 sigma_eps=5; do
    fld fog.json other.exr -D "render.fld.$option"
    different plain.exr other.exr
  done
  for option in limiter=levermore_pomraning streaming=0 boundary=marshak solver=multigrid beam=reduced ratio=2 \
    environment_beams=64 surface_points=16 spp=1 step=1 larsen_power=3 relaxation=1 iterations=0 sigma_eps=0; do
    fld fog.json other.exr -D "render.fld.$option"
    same plain.exr other.exr
  done
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
ratio=0.5 fld.ratio: 0.5 is outside \[1, 64\]
ratio=65 render.fld.ratio
streaming=-1 render.fld.streaming
streaming=2 render.fld.streaming
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
  fld fog.json all.exr --aov single,multiple,transmittance,depth
  expect 0 info all.exr
  for channel in R G B single.R multiple.B transmittance.G depth.Z; do said out.txt "^$channel "; done
  fld fog.json plain.exr
  same all.exr plain.exr
  for aov in normal albedo; do
    usage_error "--aov: the method fld has no '$aov'" render fog.json -o no.exr --method fld --aov $aov
    usage_error "--aov: the method cda has no '$aov'" render fog.json -o no.exr --method cda --aov single,$aov
  done
  usage_error '--crop: the method fld renders whole frames' render fog.json -o no.exr --method fld --crop 0,0,8x8
  absent no.exr
}

# Surfaces come from paths, and are as noisy; depth is theirs.
test_surfaces() {
  fld room.json few.exr --spp 1 --aov depth
  fld room.json many.exr --spp 16
  different few.exr many.exr
  expect 0 info few.exr
  said out.txt '^depth.Z  *[0-9.]+  *[1-9]'
}

test_statistics() {
  fld fog.json out.exr --stats stats.json
  valid_json stats.json
  said stats.json '"method": "fld"'
  for name in direct_size diffusion_size iterations cycles work residual emitted absorbed leaving; do
    said stats.json "\"$name\": \\["
  done
  for name in medium_seconds direct_seconds solve_seconds march_seconds bytes; do
    said stats.json "\"$name\": [0-9.e-]+"
  done
  said stats.json '"converged": true'
  unsaid stats.json 'nan|inf'
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr --method fld --size 24x16 -D render.fld.resolution=16
  said out.txt '16x16x16 cells of direct light, 8x8x8 of diffusion'
  expect 0 render fog.json -o out.exr --method fld --size 24x16 -D render.fld.iterations=1 -D render.fld.tolerance=1e-9
  said out.txt 'not converged'
}

test_compare() {
  expect 0 compare fog.json --methods path,fld,cda --size 16x16 --spp 4 -o compared -q
  present compared/fld.exr
  present compared/cda.exr
  present compared/path.exr
}

test_scenes_without_media() {
  for method in fld cda; do
    usage_error 'fld: the scene has no media' render empty.json -o no.exr --method $method
    absent no.exr
  done
}

test_interrupt() {
  for resolution in 200 16; do
    start render builtin:cloud_sky -o cut.exr --png cut.png --method fld --size 4096x4096 -D render.fld.spp=16 \
      -D render.fld.resolution=$resolution -D render.fld.environment_beams=2000
    kill -INT "$process"
    finished 130
    absent cut.exr
    absent cut.png
  done
}

cat > fog.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": [2, 3, 4], "sigma_a": 0.1, "g": 0.6}],
  "lights": [
    {"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 1},
    {"type": "environment", "radiance": [0.1, 0.2, 0.3]}
  ]
}
END
cat > room.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 0.5, "sigma_a": 0.1}],
  "lights": [{"type": "point", "position": [0, 1.5, 0], "intensity": 3}],
  "geometry": [
    {"quad": {"origin": [-5, -1, 5], "u": [10, 0, 0], "v": [0, 0, -10]}, "material": {"albedo": 0.5}},
    {"sphere": {"center": [0, -0.4, 0], "radius": 0.5}, "material": {"albedo": 0.8}}
  ]
}
END
cat > empty.json << 'END'
{"tyndall": 1, "camera": {"position": [0, 1, 5], "target": [0, 0, 0]}}
END

for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
no_temporary_files
finish 180
