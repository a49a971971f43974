#!/usr/bin/env bash
# Method auto from outside: when it is asked, what it says, where it says so.
# usage: test_cli_auto.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

small='--size 24x16 -D render.dom.resolution=8 -D render.dom.direct=16 -D render.lpv.resolution=8'

# chosen METHOD ARGUMENT...: a scene that names no method is rendered by METHOD, a pattern; that is said once on stderr, with
# a reason.
chosen() {
  method=$1
  shift
  # shellcheck disable=SC2086 # options
  expect 0 render "$@" -o out.exr $small --stats stats.json
  said err.txt "^method: $method(, about [0-9.]+ %, [0-9.e-]+ s)? \(.+\)$"
  checks=$((checks + 1))
  [ "$(grep -c '^method: ' err.txt)" -eq 1 ] || fail "not said once: $(cat err.txt)"
  valid_json stats.json
  said stats.json "\"method\": \"$method\""
  said stats.json '"choice": ".+"'
  expect 0 info out.exr
  said out.txt "tyndall.method +$method$"
  said out.txt 'tyndall.choice +.+'
}

any='[a-z]+'
# expected: what a choice expects is in --stats and in the metadata of the last image.
expected() {
  said stats.json '"expected_error": [0-9.e-]+'
  said stats.json '"expected_seconds": [0-9.e-]+'
  said stats.json '"choice_seconds": [0-9.e-]+'
  said out.txt 'tyndall.expected_error +[0-9.e-]+$'
  said out.txt 'tyndall.expected_seconds +[0-9.e-]+$'
}

test_scenes_that_name_none() {
  chosen "$any" fog.json
  said stats.json '"choice": "even media .*lit by the sun and an environment; [a-z]+ (comes next, at|is expected to cost)'
  expected
  chosen path empty.json
  said stats.json '"choice": ".*no media'
  chosen "$any" fog.json -D render.method=auto
}

# A scene's own method counts, unless the command line says auto.
test_scenes_that_name_one() {
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o out.exr $small -D render.method=path -D render.spp=2 --stats stats.json
  unsaid err.txt '^method: '
  said stats.json '"method": "path"'
  unsaid stats.json '"choice"'
  unsaid stats.json '"expected'
  chosen "$any" fog.json -D render.method=path --method auto
  chosen "$any" builtin:fog_cornell --method auto
}

# The picture is the one of the method by name.
test_same_picture() {
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o auto.exr $small -q --stats stats.json
  unsaid err.txt .
  name=$(sed -nE 's/.*"method": "([a-z]+)".*/\1/p' stats.json)
  # shellcheck disable=SC2086 # options
  expect 0 render fog.json -o named.exr $small -q --method "$name"
  same auto.exr named.exr
}

# What path alone can do is asked of it; samples too, but for --method auto.
test_wishes() {
  chosen path fog.json --spp 2
  said stats.json '"choice": "samples per pixel'
  expected
  chosen path fog.json --error 0.5
  unsaid stats.json '"expected'
  chosen path fog.json --time 0.1
  unsaid err.txt '^method: path, about'
  chosen path fog.json --spp 2 --resume
  said stats.json '"choice": ".*go on later'
  chosen path fog.json --crop 0,0,8x8 --spp 2
  chosen path fog.json --aov normal -D render.spp=2
  chosen "$any" fog.json --aov depth
  chosen "$any" fog.json --spp 2 --method auto
  chosen path fog.json --error 0.5 --method auto
}

# What the chosen method has no memory for is path-traced, here until an interrupt.
test_refusal() {
  what='tyndall render, without memory'
  # shellcheck disable=SC2086 # options
  (ulimit -v 900000; timeout -s INT 8 "$tyndall" render fog.json -o out.exr $small -D render.dom.resolution=512 -D render.dom.direct=1024 \
    -D render.fld.resolution=1024 -D render.pop.merged=512 -D render.pop.direct=1024 \
    -D render.lpv.resolution=256 -D render.spp=65536 --threads 1 > out.txt 2> err.txt)
  said err.txt '^method: [a-z]+, about'
  said err.txt '^method: path \([a-z]+ refused: .*not enough memory'
  expect 0 info out.exr
  said out.txt 'tyndall.method +path$'
}

test_words() {
  usage_error 'unknown method .avto.; known: path, .*dom, octaves, auto' render fog.json -o out.exr --method avto
  expect 0 render --help
  said out.txt 'auto, path, screen'
}

write_scenes '{"type": "point", "position": [1, 1.5, 1], "intensity": 3}'
test_scenes_that_name_none
test_scenes_that_name_one
test_same_picture
test_wishes
test_refusal
test_words
no_temporary_files
finish 90
