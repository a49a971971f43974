#!/usr/bin/env bash
# tyndall bake from outside: what is written, in which order, messages, interrupts, going on.
# usage: test_cli_bake.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"
. "$(dirname "$0")/bake_level.sh"

export XDG_CACHE_HOME=$PWD/cache # of the impulse responses' tables

bake() {
  expect 0 bake "$@" -q --spp 4
}

test_wrong_usage() {
  usage_error 'where to' bake level.json
  usage_error 'expected: tyndall bake' bake -o out
  usage_error 'nowhere.json' bake nowhere.json -o out
  usage_error 'is none of cache' bake level.json -o out --method magic
  usage_error 'three numbers of probes' bake level.json -o out --grid 3,4
  usage_error 'three numbers of probes' bake level.json -o out --grid 3,4,0
  usage_error 'give one' bake level.json -o out --grid 3,4,5 --grid-spacing 1
  usage_error 'more than 65536 probes|at most' bake level.json -o out --grid-spacing 0.00001
  usage_error 'neither 3 nor 5' bake level.json -o out --sh 4
  usage_error 'whole number from 0 to 64' bake level.json -o out --padding 65
  usage_error 'sign.*(UV2|TEXCOORD_1|texture coordinates)' bake level.json -o out --lightmaps
  usage_error 'points.json' bake level.json -o out --probes points.json
  echo '{"positions": [[0, 1, 0], [1, 2]]}' > points.json
  usage_error 'positions\[1\]' bake level.json -o out --probes points.json
  echo '[[0, 1, 0], [1, 2, 1e99]]' > points.json
  usage_error 'positions\[1\]' bake level.json -o out --probes points.json
  echo '{}' > points.json
  usage_error 'no points' bake level.json -o out --probes points.json
  echo '{"tyndall": 1, "geometry": [{"sphere": {"center": [0, 0, 0], "radius": 1}}]}' > ball.json
  usage_error 'no meshes to bake' bake ball.json -o out
  usage_error 'overwritten with its own copy' bake level.json -o .
  echo > file
  usage_error 'not a folder' bake level.json -o file
}

test_plans() {
  expect 0 bake level.json --dry-run
  said out.txt '^meshes: 2 by lightmap \([0-9]+ texels\), 2 by vertex$'
  said out.txt '^about [0-9]+ receivers, .* of memory$'
  expect 0 bake level.json --dry-run --vertices
  said out.txt '0 by lightmap .*4 by vertex'
  expect 0 bake level.json --dry-run --lightmaps --vertices
  said out.txt '2 by lightmap .*2 by vertex'
  expect 0 bake level.json --dry-run --grid-spacing 0.9
  said out.txt '^light grid: 3 x 3 x 3$'
  expect 0 bake plain.glb --dry-run
  said out.txt '0 by lightmap .*3 by vertex'
  absent dry
}

# rmse A B: the relative RMSE of one lightmap from another.
rmse() {
  "$tyndall" diff "$1" "$2" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["all"]["relative_rmse"])'
}

# Denoised lightmaps stand beside those that are not, have less noise (measured: 0.23 of it) and as much light.
test_denoised_maps() {
  expect 0 bake level.json -o noisy --lightmaps --vertices --size 48x32 --spp 16 --denoise -q
  expect 0 bake level.json -o smooth --lightmaps --vertices --size 48x32 --spp 1024 --seed 7 -q
  present noisy/the_room_1.denoised.png
  said noisy/bake.json '"denoised": "the_room_1.denoised.exr"'
  unsaid smooth/bake.json 'denoised'
  absent smooth/the_room_1.denoised.exr
  raw=$(rmse noisy/the_room_1.exr smooth/the_room_1.exr)
  denoised=$(rmse noisy/the_room_1.denoised.exr smooth/the_room_1.exr)
  checks=$((checks + 1))
  python3 -c "import sys; sys.exit(not $denoised < 0.4 * $raw)" || fail "denoised $denoised, raw $raw"
  checks=$((checks + 1))
  python3 -c "import sys; sys.exit(not 0 < $raw < 1)" || fail "raw $raw"
  rm noisy/the_room_1.denoised.exr
  expect 0 bake level.json -o noisy --lightmaps --vertices --size 48x32 --spp 16 --denoise --resume
  present noisy/the_room_1.denoised.exr
  usage_error 'two halves of the paths' bake level.json -o one --spp 1 --denoise
}

test_everything_at_once() {
  echo '[[0, 1, 0], [0, 0.5, 0.5]]' > points.json
  bake level.json -o all --lightmaps --vertices --size 48x32 --grid 2,3,4 --probes points.json --sh 5
  for file in the_room_1.exr the_room_1.png sign.exr sign_2.exr grid.exr grid.png probes.json bake.json level.glb; do
    present "all/$file"
  done
  no_temporary_files
  valid_json all/bake.json
  valid_json all/probes.json
  expect 0 info all/the_room_1.exr
  said out.txt '^size +48x32'
  for channel in direct.R indirect.G single.B multiple.R L1.RX coverage.A samples.N variance.B; do
    said out.txt "^$channel "
  done
  expect 0 info all/grid.exr
  said out.txt '^size +2x12'
  said out.txt '^sh24.B'
  said out.txt '^direct.sh0.R'
  unsaid out.txt '^sh25'
  expect 0 info all/level.glb
  said out.txt '^meshes +4, 8 triangles'
  said all/bake.json '"complete": true'
  said all/bake.json '"condon_shortley": "none"'
  said all/bake.json '"color_scale"'
  python3 - << 'END' || fail "the copy is not what it should be"
import json, struct
def read(name):
    b = open(name, 'rb').read()
    n = struct.unpack('<I', b[12:16])[0]
    return json.loads(b[20:20 + n]), b[28 + n:]
old, old_body = read('level.glb')
new, body = read('all/level.glb')
assert new['extras']['kept'] == [1, 2.5]
assert body.startswith(old_body[:old['buffers'][0]['byteLength']])
for key in ('accessors', 'bufferViews'): assert new[key][:len(old[key])] == old[key]
assert new['meshes'][0] == old['meshes'][0]  # it has a lightmap
scale = new['extras']['tyndall']['color_scale']
colored = [new['meshes'][new['nodes'][n]['mesh']]['primitives'][0]['attributes'] for n in (1, 2)]
assert new['nodes'][1]['mesh'] != new['nodes'][2]['mesh']
assert colored[0]['POSITION'] == colored[1]['POSITION'] and colored[0]['COLOR_0'] != colored[1]['COLOR_0']
brightest = 0
for attributes in colored:
    accessor = new['accessors'][attributes['COLOR_0']]
    view = new['bufferViews'][accessor['bufferView']]
    values = struct.unpack_from('<12f', body, view['byteOffset'])
    assert accessor['count'] == 4 and all(0 <= v <= 1 for v in values)
    assert values[0] > values[2]  # the lamp is reddish
    brightest = max(brightest, *values)
assert abs(brightest - 1) < 1e-6 and scale > 0
record = json.load(open('all/bake.json'))
copy = [f for f in record['files'] if f['kind'] == 'gltf'][0]
assert abs(copy['color_scale'] / scale - 1) < 1e-6
room = [f for f in record['files'] if f['file'] == 'the_room_1.exr'][0]
assert [m['primitive'] for m in room['meshes']] == [0, 1]
probes = json.load(open('all/probes.json'))['probes']
assert len(probes) == 2 and len(probes[0]['sh']) == 25 and len(probes[0]['sh'][0]) == 3
for t in range(25):
    for c in range(3):
        assert abs(probes[0]['sh'][t][c] - sum(l[t][c] for l in probes[0]['layers'].values())) < 1e-4
END
  checks=$((checks + 1))
}

test_files_apart() {
  bake apart.gltf -o apart --vertices -D 'lights=[{"type": "point", "position": [0.3, 1.5, 0.2], "intensity": [3, 2, 1]}]'
  present apart/apart.glb
  expect 0 info apart/apart.glb
  said out.txt '^meshes +3, 6 triangles'
}

test_points_alone() {
  bake level.json -o grid --grid 2,2,2
  present grid/grid.exr
  absent grid/the_room_1.exr
  expect 0 info grid/grid.exr
  unsaid out.txt '^sh9'
}

test_threads_and_seeds() {
  bake level.json -o one --size 32x32 --threads 1
  bake level.json -o two --size 32x32 --threads 2
  bake level.json -o other --size 32x32 --seed 5
  for file in the_room_1 sign_2; do same "one/$file.exr" "two/$file.exr"; done
  expect 0 diff one/the_room_1.exr other/the_room_1.exr
  unsaid out.txt '^values that differ: 0$'
}

test_methods() {
  bake level.json -o surfaces --size 32x32 --method surfaces
  for method in cache impulse attenuation; do
    bake level.json -o $method --size 32x32 --method $method
    same surfaces/the_room_1.exr $method/the_room_1.exr
  done
  said impulse/bake.json '"composition": "collisions"'
  bake level.json -o published --size 32x32 --method impulse --composition published
  said published/bake.json '"composition": "published"'
  unsaid surfaces/bake.json composition
  expect 2 bake level.json -o no --method impulse --composition other
  bake level.json -o path --size 32x32 --method path
  present path/the_room_1.exr
}

test_interrupts_and_going_on() {
  options='--size 64x64 --spp 2048 --method surfaces'
  # shellcheck disable=SC2086 # options
  expect 0 bake level.json -o whole $options -q
  # shellcheck disable=SC2086
  start bake level.json -o parts $options
  kill -INT "$process"
  finished 130
  said parts/bake.json '"complete": false'
  absent parts/level.glb
  valid_json parts/bake.json
  # shellcheck disable=SC2086
  usage_error 'the state of another bake' bake level.json -o parts $options --seed 7 --resume
  # shellcheck disable=SC2086
  expect 0 bake level.json -o parts $options --resume -q
  said parts/bake.json '"complete": true'
  for file in the_room_1 sign sign_2; do same "whole/$file.exr" "parts/$file.exr"; done
  # What is done stays; what is missing is baked again.
  touch -d '2001-02-03' parts/the_room_1.exr
  rm parts/sign.exr parts/level.glb
  # shellcheck disable=SC2086
  expect 0 bake level.json -o parts $options --resume
  said out.txt '3 of 3 done, 2 of them before'
  present parts/level.glb
  same whole/sign.exr parts/sign.exr
  checks=$((checks + 1))
  [ "$(date -r parts/the_room_1.exr +%Y)" = 2001 ] || fail 'a finished map was baked again'
  echo nonsense > parts/bake.state
  # shellcheck disable=SC2086
  usage_error 'not the state of a bake' bake level.json -o parts $options --resume
  no_temporary_files
}

command -v python3 > /dev/null || { echo 'skipped: there is no python3'; exit 0; }
make_level
test_wrong_usage
test_plans
test_everything_at_once
test_denoised_maps
test_files_apart
test_points_alone
test_threads_and_seeds
test_methods
test_interrupts_and_going_on
finish 100
