#!/usr/bin/env bash
# tyndall render and compare by lpv from outside: options, modes, parts, channels, lights, messages, interrupts.
# usage: test_cli_lpv.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.lpv.resolution=8 -q'

# lpv SCENE OUT ARGUMENT...: a small image, by lpv.
lpv() {
  small_by lpv "$@"
}

test_scenes_name_the_method() {
  named_by_scenes lpv '{"resolution": 8}'
}

# Every key changes what it should, or nothing at all.
test_options() {
  changed_by lpv fog.json mode=published resolution=10 place=camera cascades=2 bands=3 window=0.5 iterations=2 \
    tolerance=0.3 map_side=32 samples=2 block_side=1 shadow_side=16 half=false step=0.3 spp=4
  kept_by lpv fog.json mode=links parts=all place=scene extent=5 cascades=1 bands=2 window=auto window=0 iterations=auto \
    tolerance=0.01 map_side=256 samples=8 block_side=3 shadow_side=512 shadow_rays=true half=true step=1 spp=1
  lpv fog.json wide.exr -D render.lpv.place=camera
  lpv fog.json narrow.exr -D render.lpv.place=camera -D render.lpv.extent=6
  different wide.exr narrow.exr
}

# What the paper compares with: each less or other than all of it.
test_parts() {
  lpv fog.json full.exr
  last=full.exr
  for parts in shadow_map plain plain_march single both; do
    lpv fog.json $parts.exr -D render.lpv.parts=$parts
    different $last $parts.exr
    different full.exr $parts.exr
    last=$parts.exr
  done
}

# Surfaces in clear air, and media without surfaces.
test_without() {
  lpv clear.json clear.exr
  lpv clear.json direct.exr -D render.lpv.parts=shadow_map
  different clear.exr direct.exr
  expect 0 info clear.exr
  said out.txt '^G  *[0-9.e-]+  *[0-9.]*[1-9]'
  lpv air.json air.exr
  expect 0 info air.exr
  said out.txt '^G  *[0-9.e-]+  *[0-9.]*[1-9]'
}

test_wrong_options() {
  refused_options lpv << 'END'
mod=links did you mean .*mode
mode=link did you mean .*links
parts=al render.lpv.parts
place=scen did you mean .*scene
resolution=3 render.lpv.resolution: 3 is outside \[4, 256\]
resolution=257 render.lpv.resolution
extent=0 render.lpv.extent
cascades=0 render.lpv.cascades
cascades=7 render.lpv.cascades
bands=1 render.lpv.bands
bands=4 render.lpv.bands
window=-2 render.lpv.window
window=-1 render.lpv.window: -1 is outside \[0, 1\]; write "auto"
window=2 render.lpv.window
iterations=-1 render.lpv.iterations
iterations=4097 render.lpv.iterations
tolerance=0 render.lpv.tolerance
tolerance=1 render.lpv.tolerance
map_side=8 render.lpv.map_side
samples=0 render.lpv.samples
light_samples=257 render.lpv.light_samples
block_side=17 render.lpv.block_side
shadow_side=4097 render.lpv.shadow_side
shadow_rays=1 render.lpv.shadow_rays
half=no render.lpv.half
step=9 render.lpv.step
spp=65 render.lpv.spp
END
}

test_lights() {
  lpv builtin:cornell_fog area.exr
  lpv fog.json sky.exr -D 'lights[1]={"type": "environment", "radiance": 1}'
  lpv fog.json emitter.exr -D 'lights=[]' \
    -D 'geometry=[{"sphere": {"center": [0, 0, 0], "radius": 1}, "material": {"albedo": 0, "emission": 1}}]'
  lpv fog.json dark.exr -D 'lights=[]'
  different emitter.exr dark.exr
  lpv fog.json without.exr
  different sky.exr without.exr
  lpv builtin:cornell_fog rough.exr -D render.lpv.light_samples=1
  different area.exr rough.exr
  lpv fog.json glow.exr -D 'lights=[]' -D 'media[0].emission={"radiance": 1}'
  different glow.exr dark.exr
}

test_channels() {
  channels lpv single,multiple,transmittance,depth,normal \
    'single.R multiple.B transmittance.G depth.Z normal.X' 'albedo variance'
}

test_statistics() {
  for mode in links published; do
    lpv fog.json out.exr --stats stats.json -D render.lpv.mode=$mode -D render.lpv.cascades=2
    statistics lpv 'size reflected scattered absorbed blocked escaped left' 'cell iterations medium_seconds map_seconds
      shadow_seconds reflected_seconds scattered_seconds blocker_seconds prepare_seconds propagate_seconds
      gather_seconds view_seconds surface_seconds march_seconds single_seconds compose_seconds rays ray_seconds'
    said stats.json '"rays": [1-9]'
  done
  expect 0 render fog.json -o out.exr --method lpv --size 24x16 -D render.lpv.resolution=8 -D render.lpv.iterations=5
  said out.txt '^lpv: 24x16, [0-9]+x[0-9]+x[0-9]+ cells of [0-9.]+ m, 5 iterations, '
  unsaid out.txt '^surfaces'
}

test_compare() {
  compares 'path lpv' -D render.lpv.resolution=8
}

test_builtin() {
  for name in atrium fog_cornell; do
    expect 0 render builtin:$name -o out.exr --size 32x18 -D render.lpv.resolution=16
    said out.txt '^lpv: 32x18'
  done
}

test_bench() {
  expect 0 bench lpv --quick --size 32x18 --runs 1
  for words in 'propagate, 8 times' 'propagate_gflops: [0-9.]+' 'fraction_of_peak: [0-9.]+' 'mrays: [0-9.]+' 'a frame of .*:' \
    'resolution: \[32, 18\]'; do
    said out.txt "$words"
  done
  expect 0 bench lpv --quick --size 32x18 --runs 1 --json --data nowhere
  cp out.txt bench.json
  valid_json bench.json
  said bench.json '"fraction_of_peak": [0-9.]+'
  said bench.json '"scene": "atrium"'
  unsaid bench.json nan
}

test_interrupt() {
  interrupted builtin:atrium -D render.lpv.spp=64 -D render.lpv.resolution=128
}

cat > fog.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-3, -1, -3], [3, 2, 5]], "sigma_s": [0.2, 0.3, 0.4], "sigma_a": 0.05, "g": 0.4}],
  "lights": [
    {"type": "spot", "position": [0, 1.8, 0], "direction": [-0.2, -1, -0.1], "intensity": 9},
    {"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 2}
  ],
  "geometry": [
    {"quad": {"origin": [-3, -1, 3], "u": [6, 0, 0], "v": [0, 0, -6]}, "material": {"albedo": 0.6}},
    {"box": [[-0.4, -1, -0.4], [0.4, 0, 0.4]], "material": {"albedo": [0.8, 0.3, 0.2]}}
  ]
}
END
cat > clear.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "lights": [{"type": "point", "position": [0, 1.8, 0], "intensity": 9}],
  "geometry": [
    {"quad": {"origin": [-3, -1, 3], "u": [6, 0, 0], "v": [0, 0, -6]}, "material": {"albedo": 0.6}},
    {"box": [[-0.4, -1, -0.4], [0.4, 0, 0.4]], "material": {"albedo": [0.8, 0.3, 0.2]}}
  ]
}
END
cat > air.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 1, "sigma_a": 0.1}],
  "lights": [{"type": "point", "position": [0, 1.8, 0], "intensity": 9}]
}
END

run_tests 200
