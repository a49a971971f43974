#!/usr/bin/env bash
# Renders that are interrupted, killed and taken up again. usage: test_cli_resume.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

scene="builtin:cornell_fog --size 96x72"

# wait_for FILE: until it is there and not empty.
wait_for() {
  for _ in $(seq 200); do
    [ -s "$1" ] && return
    sleep 0.05
  done
  fail "no $1 within 10 s"
}

# killed ARGUMENT...: a render that is killed as soon as it has written a state.
killed() {
  start "$@"
  wait_for out.exr.state
  kill -9 "$process"
  wait "$process" 2> /dev/null
  checks=$((checks + 1))
  [ ! -e out.exr ] || fail "it was finished before it could be killed"
  rm -f ./*.tmp
}

test_killed() {
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 200 -o whole.exr -q --seed 5 --aov variance
  rm -f out.exr*
  # shellcheck disable=SC2086
  killed render $scene --spp 200 -o out.exr --seed 5 --aov variance --resume --checkpoint 0.1 --threads 1
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 200 -o out.exr --seed 5 --aov variance --resume --stats out.json
  said out.txt 'resumed'
  said out.json '"resumed": true'
  said out.json '"spp": 200'
  same whole.exr out.exr
  present out.exr.state
  # More samples on top of those, and all of them at once.
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 220 -o out.exr --seed 5 --aov variance --resume -q
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 220 -o whole.exr --seed 5 --aov variance -q
  same whole.exr out.exr
  no_temporary_files
}

test_interrupted() {
  rm -f out.exr*
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 200 -o whole.exr -q --crop 7,9,80x50
  # shellcheck disable=SC2086
  start render $scene --spp 200 -o out.exr --crop 7,9,80x50 --resume --threads 1
  kill -INT "$process"
  finished 130
  present out.exr.state
  # shellcheck disable=SC2086
  expect 0 render $scene --spp 200 -o out.exr -q --crop 7,9,80x50 --resume
  same whole.exr out.exr
  expect 0 info out.exr
  said out.txt '^tyndall.spp +(200|2e\+02)$'
  said out.txt '^tyndall.complete +1$'
  unsaid out.txt 'samples'
}

test_partial_images_tell_their_samples() {
  # shellcheck disable=SC2086
  start render $scene --time 100 -o part.exr
  kill -INT "$process"
  finished 130
  expect 0 info part.exr --json
  valid_json out.txt
  said out.txt '"tyndall.complete": "0"'
}

test_png() {
  expect 0 render builtin:cube_g0 -o out.png --size 16x16 --spp 2 --resume
  present out.png.state
  expect 0 render builtin:cube_g0 -o out.png --size 16x16 --spp 2 --resume
  said out.txt 'resumed'
}

test_time() {
  rm -f out.exr*
  expect 0 render builtin:cornell_fog --size 32x24 --time 0.5 -o out.exr --resume
  cp out.exr first.exr
  expect 0 render builtin:cornell_fog --size 32x24 --time 0.5 -o out.exr --resume
  same first.exr out.exr
  expect 0 render builtin:cornell_fog --size 32x24 --time 1 -o out.exr --resume
  expect 0 diff first.exr out.exr
  unsaid out.txt '^values that differ: 0$'
}

# Every damage is one clear line.
test_wrong_states() {
  rm -f out.exr*
  small="builtin:cube_g0 --size 16x16 -o out.exr --resume"
  # shellcheck disable=SC2086
  expect 0 render $small --spp 4
  cp out.exr.state good
  # shellcheck disable=SC2086
  {
    usage_error 'out.exr.state: the state is of seed 0, not 4' render $small --spp 4 --seed 4
    usage_error 'the state has 4 samples per pixel, more than the 2' render $small --spp 2
    usage_error 'the state is of scene' render $small --spp 4 -D 'media[0].g=0.5'
    usage_error 'the state is of 16 x 16 pixels' render $small --spp 4 --size 8x8
    usage_error 'the state is of the crop 0,0,16x16' render $small --spp 4 --crop 0,0,8x8
    usage_error 'other channels' render $small --spp 4 --aov depth
    head -c 1000 good > out.exr.state
    usage_error 'out.exr.state: .* cut short' render $small --spp 4
    head -c 10 good > out.exr.state
    usage_error 'out.exr.state: .* cut short' render $small --spp 4
    : > out.exr.state
    usage_error 'out.exr.state: .* cut short' render $small --spp 4
    { head -c 5000 good; printf 'x'; tail -c +5002 good; } > out.exr.state
    usage_error 'out.exr.state: .* damaged' render $small --spp 4
    tr '\0-\377' '\1-\377\0' < good > out.exr.state
    usage_error 'out.exr.state: .* not the state of a render' render $small --spp 4
    rm out.exr.state && mkdir out.exr.state
    usage_error 'out.exr.state' render $small --spp 4
  }
}

test_killed
test_interrupted
test_partial_images_tell_their_samples
test_png
test_time
test_wrong_states
finish 75
