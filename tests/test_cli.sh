#!/usr/bin/env bash
# The command line tool from outside: what it prints, writes and returns.
# usage: test_cli.sh TYNDALL (works in the current folder, which it empties)
. "$(dirname "$0")/cli.sh"

small="--size 24x16 --spp 2"

test_help() {
  expect 0 --help
  for command in render info diff merge compare bench; do said out.txt "^  $command "; done
  expect 0 --version
  said out.txt '^tyndall [0-9]+\.[0-9]+\.[0-9]+$'
  for command in render info diff merge compare bench; do
    expect 0 "$command" --help
    said out.txt "^usage: tyndall $command "
    said out.txt '--threads N'
    expect 0 "$command" --version
  done
  expect 0 render -h
  said out.txt '--exposure STOPS'
  expect 2
}

test_usage() {
  usage_error "did you mean 'render'" rendr
  usage_error 'render, view, info, diff, merge, denoise, compare' nonsense
  usage_error "unknown command ''" ''
  usage_error 'did you mean --spp' render builtin:cube_g0 -o a.exr --sp 4
  usage_error 'unknown option --zzzzzzzz ' render builtin:cube_g0 -o a.exr --zzzzzzzz
  usage_error 'unknown option -z' render builtin:cube_g0 -z
  usage_error 'expected: tyndall render SCENE' render -o a.exr
  usage_error 'one argument too many' render builtin:cube_g0 more -o a.exr
  usage_error '-o OUT' render builtin:cube_g0
  usage_error '--output needs a FILE' render builtin:cube_g0 -o
  usage_error '--quiet takes no value' render builtin:cube_g0 --quiet=1
  for value in 0 -3 1.5 8x '' 0x8 ' 8' 99999999 1e3 nan; do
    usage_error '--spp: .* whole number' render builtin:cube_g0 -o a.exr "--spp=$value"
  done
  for value in -1 18446744073709551616 x; do
    usage_error '--seed: .* whole number' render builtin:cube_g0 -o a.exr --seed "$value"
  done
  for value in nan inf 0 -1 1s 0x1; do
    usage_error '--time: .* number' render builtin:cube_g0 -o a.exr --time "$value"
  done
  for value in 10 0x5 5x0 5x 5x5x5 99999x1; do
    usage_error '--size: .* size like' render builtin:cube_g0 -o a.exr --size "$value"
  done
  usage_error '--threads: ' render builtin:cube_g0 -o a.exr --threads 9999
  usage_error '--progress: .*auto\|plain' render builtin:cube_g0 -o a.exr --progress fancy
  usage_error "unknown method 'fog'; known: path" render builtin:cube_g0 -o a.exr --method fog
  for value in dept depth, all,x ''; do
    usage_error '--aov' render builtin:cube_g0 -o a.exr "--aov=$value"
  done
  usage_error "did you mean 'depth'" render builtin:cube_g0 -o a.exr --aov samples,dpeth
  usage_error '--aov is for .exr' render builtin:cube_g0 -o a.png --aov depth
  for value in 1 1,2 1,2,3 1,2,3x -1,2,3x4 1,2,0x4 1,,3x4 1,2,3x4x5 99999,0,1x1 a,2,3x4; do
    usage_error '--crop: .* like 10,20,64x48' render builtin:cube_g0 -o a.exr --crop "$value"
  done
  usage_error 'crop: 8 x 8 pixels at \(20, 0\) are not within 24 x 16' \
    render builtin:cube_g0 -o a.exr --size 24x16 --crop 20,0,8x8
  usage_error '--checkpoint .*--resume' render builtin:cube_g0 -o a.exr --checkpoint 1
  usage_error '--checkpoint: .* number' render builtin:cube_g0 -o a.exr --resume --checkpoint 0
  usage_error 'extension' render builtin:cube_g0 -o a.jpg
  usage_error 'extension' render builtin:cube_g0 -o a.exr --png a.exr
  usage_error 'missing' render builtin:cube_g0 -o missing/a.exr
  usage_error 'missing' render builtin:cube_g0 -o a.exr --stats missing/a.json
  mkdir -p folder.exr
  usage_error 'folder.exr' render builtin:cube_g0 -o folder.exr
  touch plain
  usage_error 'plain' render builtin:cube_g0 -o plain/a.exr
  if [ "$(id -u)" -ne 0 ]; then
    mkdir -p locked && chmod 555 locked
    usage_error 'locked' render builtin:cube_g0 -o locked/a.exr
  fi
  usage_error "did you mean 'path'" bench pat
  usage_error 'machine, path, direct, rays, screen, fld, pop, lpv, dom, octaves, gradient, denoise, impulse, bake, view, load, device, edit, all' bench everything
  absent a.exr
}

test_scene_errors() {
  usage_error 'nowhere.json' render nowhere.json -o a.exr
  usage_error 'cube_g0' render builtin:cube_g9 -o a.exr
  echo '{"tyndall": 1, "medai": []}' > typo.json
  usage_error 'typo.json.*medai.*media' render typo.json -o a.exr
  echo '{"tyndall": 1,' > broken.json
  usage_error 'broken.json' render broken.json -o a.exr
  usage_error 'media\[0\]\.g' render builtin:cube_g0 -o a.exr -D 'media[0].g=2'
  usage_error 'renderr' render builtin:cube_g0 -o a.exr -D renderr.spp=2
  usage_error '' render builtin:cube_g0 -o a.exr -D nonsense
  absent a.exr
}

test_render() {
  # shellcheck disable=SC2086
  expect 0 render builtin:cube_g0 -o a.exr $small --png a.png --stats a.json --seed 18446744073709551615
  said out.txt '^wrote a.exr$'
  said out.txt '^wrote a.png$'
  present a.exr
  said a.png 'PNG'
  valid_json a.json
  said a.json '"spp": 2'
  said a.json '"paths": 768'
  said a.json '"complete": true'
  said a.json '"seed": 18446744073709551615'
  said a.json '"isa": "[a-z0-9]'
  said a.json '"peak_memory_bytes": [0-9]{6}'
  expect 0 info a.exr
  said out.txt '^size +24x16$'
  said out.txt '^tyndall.version +[0-9]'
  said out.txt '^tyndall.method +path$'
  said out.txt '^tyndall.spp +2$'
  said out.txt '^tyndall.seed +18446744073709551615$'
  said out.txt '^tyndall.scene +[0-9a-f]{16}$'
  said out.txt '^tyndall.complete +1$'
  said out.txt '^tyndall.(seconds|error) +[0-9]'
  unsaid out.txt 'variance|NaN|Inf'

  expect 0 render builtin:cube_g0 -o=b.exr --size=24x16 --spp=2 -q
  absent b.exr
  expect 0 render builtin:cube_g0 -ob.exr --size=24x16 --spp=2 -q --aov variance
  checks=$((checks + 1))
  [ -z "$(cat out.txt err.txt)" ] || fail "--quiet printed something"
  expect 0 info b.exr
  said out.txt '^variance.R '

  expect 0 render builtin:cube_g0 -o b.exr --size 24x16 --spp 3 -q --aov all --crop 3,4,10x5
  expect 0 info b.exr
  said out.txt '^size +10x5'
  for channel in variance.R transmittance.G depth.Z normal.X albedo.B single.R multiple.G; do
    said out.txt "^$channel "
  done
  said out.txt '^samples.N +3 +3 +3$'
  expect 0 render builtin:cube_g0 -o b.exr --size 24x16 --spp 1 -q --aov depth,normal
  expect 0 info b.exr
  said out.txt '^normal.Z '
  unsaid out.txt '^(variance|samples|albedo)'
  expect 1 render builtin:cube_g0 -o huge.exr --size 65536x65536 --aov all
  said err.txt '^tyndall: .*65536 x 65536 pixels: not enough memory: [0-9.]+ MiB are needed, and the machine has'
  absent huge.exr

  # shellcheck disable=SC2086
  expect 0 render builtin:cube_g0 -o c.png $small
  said c.png 'PNG'
  expect 0 render builtin:cube_g0 -o d.exr --size 8x8 -D render.spp=3 -D 'media[0].g=0.5'
  expect 0 info d.exr --json
  said out.txt '"tyndall.spp": "3"'
  expect 0 render builtin:cube_g0 -o d.exr --size 8x8 --error 0.5
  expect 0 render builtin:cube_g0 -o d.exr --size 8x8 --time 0.3 --stats d.json
  said d.json '"complete": true'
  expect 0 render builtin:cube_g0 -o d.exr --size 64x64 --spp 8 --progress json
  said err.txt '^\{"stage": "path", "fraction": [0-9.]+, .*"total": 8\}$'
  expect 0 render builtin:cube_g0 -o d.exr --size 64x64 --spp 8 --progress none
  checks=$((checks + 1))
  [ ! -s err.txt ] || fail "--progress none printed: $(cat err.txt)"
}

test_same_everywhere() {
  expect 0 render builtin:cornell_fog -o one.exr --size 32x24 --spp 4 --threads 1
  expect 0 render builtin:cornell_fog -o two.exr --size 32x24 --spp 4 --threads 2
  expect 0 render builtin:cornell_fog -o other.exr --size 32x24 --spp 4 --threads 2 --seed 1
  expect 0 diff one.exr two.exr --json
  valid_json out.txt
  said out.txt '"differing": 0,'
  expect 0 diff one.exr other.exr --json --png heat.png
  said out.txt '"differing": [1-9]'
  said heat.png 'PNG'
  expect 0 diff one.exr one.exr --block 4
  said out.txt '^all +1 +0 +0 +0$'
  usage_error '' diff one.exr a.exr
  usage_error 'missing.exr' diff one.exr missing.exr
  usage_error '' diff one.exr one.exr --block 100
}

test_info() {
  expect 0 info -- builtin:cornell_fog
  said out.txt '^medium 0 +fog: sigma_s 0.5'
  said out.txt '^memory '
  expect 0 info builtin:cube_g0.7 --json
  valid_json out.txt
  said out.txt '"g": \[0.7, 0.7, 0.7\]'
  expect 0 info builtin:cube_g0 -D 'media[0].g=0.25' --json
  said out.txt '"g": \[0.25, 0.25, 0.25\]'
  echo 'neither this nor that' > text.txt
  usage_error 'text.txt: neither' info text.txt
  usage_error 'missing' info missing.exr
  usage_error 'folder.exr' info folder.exr
  printf 'v/1\001broken' > broken.exr
  usage_error 'broken.exr' info broken.exr
  expect 0 info --media
  said out.txt '^Wholemilk .* 2550 .*may be diluted'
  said out.txt '^Fog .*needs its visibility'
  expect 0 info --media 'Jerlov II'
  said out.txt '^Jerlov II .* 0.2922 '
  expect 0 info --media --json '{"sigma_s": [0.1, 0.25, 0.5], "g": 0.75}'
  valid_json out.txt
  said out.txt '"sigma_s": \[0.1'
  usage_error 'did you mean "Wholemilk"' info --media wholmilk
  usage_error 'Fog needs its visibility in metres: Fog:50' info --media fog
  usage_error 'expected: tyndall info FILE' info
}

test_bench() {
  expect 0 bench path --scenes cube_g0,cube_g0.7 --size 16x16 --spp 2 --runs 1
  said out.txt '^    cube_g0:$'
  said out.txt '^      relative_rmse: [0-9.e-]+$'
  said out.txt '^    cube_g0.7:$'
  cp one.exr cornell_fog.exr
  expect 0 bench path --scenes cornell_fog --size 32x24 --spp 4 --runs 3 --json -q --reference .
  valid_json out.txt
  printf '{"tyndall": 1, "lights": [{"type": "environment", "radiance": 1}]}' > white.json
  expect 0 bench path --scenes ./white.json,cube_g0 --size 8x8 --spp 2 --runs 1
  said out.txt '^    white:$'
  said out.txt '^    cube_g0:$'
  expect 2 bench path --scenes nosuch.json --size 8x8 --spp 2
  expect 2 bench path --scenes nosuch --size 8x8 --spp 2
  expect 0 bench rays --size 17x9 --runs 1 --threads 2
  said out.txt '^  triangles: 260642$'
  said out.txt '^  size: \[17, 9\]$'
  said out.txt '^    - rays: "camera_packets"$'
  said out.txt '^    - rays: "bounce_single"$'
  said out.txt '^      mrays_per_second: [0-9.]+$'
  printf 'v -1 0 -1\nv 1 0 -1\nv 1 1 1\nv -1 0 1\nf 1 2 3 4\n' > board.obj
  expect 0 bench rays --mesh board.obj --size 16x16 --runs 1 --threads 1 --json
  valid_json out.txt
  said out.txt '"triangles": 2'
  expect 2 bench rays --mesh missing.obj
}

test_interrupt() {
  for signal in INT TERM HUP; do
    rm -f part.exr
    start render builtin:cornell_fog -o part.exr --size 64x48 --time 300 --stats part.json
    kill -$signal "$process"
    finished $((128 + $(kill -l $signal)))
    said part.json '"complete": false'
    expect 0 info part.exr
    said out.txt '^size +64x48$'
    said out.txt '^tyndall.complete +0$'
  done
  mkdir -p going
  start render builtin:cornell_fog -o going/a.exr --size 64x48 --time 2
  rmdir going
  finished 1
  said err.txt '^tyndall: .*going/a.exr'
  no_temporary_files
}

test_help
test_usage
test_scene_errors
test_render
test_same_everywhere
test_info
test_bench
test_interrupt
finish 240
