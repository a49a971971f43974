#!/usr/bin/env bash
# tyndall render and compare by dom from outside: options, channels, surfaces, messages, interrupts.
# usage: test_cli_dom.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.dom.resolution=8 -D render.dom.direct=16 -q'

# dom SCENE OUT ARGUMENT...: a small image by dom.
dom() {
  small_by dom "$@"
}

# The scene names the method; threads do not matter.
test_scenes_name_the_method() {
  dom fog.json asked.exr
  expect 0 render fog.json -o named.exr --size 24x16 -q \
    -D 'render={"method": "dom", "dom": {"resolution": 8, "direct": 16}}'
  same asked.exr named.exr
  dom fog.json again.exr --threads 1
  same asked.exr again.exr
}

# Every key changes what it should, or nothing at all.
test_options() {
  dom fog.json plain.exr
  for option in resolution=12 direct=20 directions=48 bands=2 tolerance=0.3 iterations=1 environment_beams=7 spp=4 \
    step=0.3 acceleration=none; do
    dom fog.json other.exr -D "render.dom.$option"
    different plain.exr other.exr
  done
  for option in resolution=8 direct=16 directions=96 bands=0 tolerance=1e-3 iterations=0 iterations=100 \
    environment_beams=64 surface_points=3 spp=1 step=1 acceleration=diffusion; do
    dom fog.json other.exr -D "render.dom.$option"
    same plain.exr other.exr
  done
  dom fog.json seeded.exr --seed 3
  different plain.exr seeded.exr
}

test_wrong_options() {
  refused_options dom << 'END'
direction=48 did you mean .*directions
directions=7 render.dom.directions
directions=1025 render.dom.directions
resolution=513 render.dom.resolution
resolution=3 dom.resolution: 3 is outside \[4, 512\]
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
  usage_error 'dom: the scene has no media' render empty.json -o no.exr --method dom
  usage_error "--aov: the method dom has no 'normal'" render fog.json -o no.exr --method dom --aov normal
  usage_error '--crop: the method dom renders whole frames' render fog.json -o no.exr --method dom --crop 0,0,8x8
  absent no.exr
}

test_channels() {
  dom fog.json all.exr --aov single,multiple,transmittance,depth
  expect 0 info all.exr
  for channel in R G B single.R multiple.B transmittance.G depth.Z; do said out.txt "^$channel "; done
  dom fog.json plain.exr
  same all.exr plain.exr
}

# Surfaces come from paths, and are as noisy; depth is theirs.
test_surfaces() {
  dom room.json few.exr --spp 1 --aov depth
  dom room.json many.exr --spp 16
  different few.exr many.exr
  expect 0 info few.exr
  said out.txt '^depth.Z  *[0-9.]+  *[1-9]'
}

test_statistics() {
  dom fog.json out.exr --stats stats.json
  valid_json stats.json
  said stats.json '"method": "dom"'
  for name in direct_size size sweeps cycles change emitted absorbed leaving; do said stats.json "\"$name\": \\["; done
  for name in medium_seconds direct_seconds source_seconds solve_seconds sweep_seconds march_seconds bytes; do
    said stats.json "\"$name\": [0-9.e-]+"
  done
  said stats.json '"converged": true'
  unsaid stats.json 'nan|inf'
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr --method dom ${small% -q}
  said out.txt '16x16x16 cells of direct light, 8x8x8 of 96 ordinates, [0-9]+ sweeps, '
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr --method dom ${small% -q} -D render.dom.iterations=1 -D render.dom.tolerance=1e-9
  said out.txt 'sweeps, not converged'
}

test_compare() {
  expect 0 compare fog.json --methods path,dom --size 16x16 --spp 4 -o compared -q
  present compared/dom.exr
}

test_interrupt() {
  for resolution in 128 8; do
    start render builtin:cloud_sky -o cut.exr --png cut.png --method dom --size 4096x4096 -D render.dom.spp=16 \
      -D render.dom.resolution=$resolution -D render.dom.directions=1024
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
finish 140
