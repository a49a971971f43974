#!/usr/bin/env bash
# tyndall denoise and tyndall render --denoise from outside; test_denoise.c looks at the numbers.
# usage: test_cli_denoise.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

# draw NAME ARGUMENT...: NAME.exr of one scene and size.
draw() {
  name=$1
  shift
  expect 0 render builtin:cornell_fog --method path -o "$name.exr" --size 48x36 -q --spp 8 "$@"
}

test_render() {
  draw raw --aov half --seed 3
  draw both --seed 3 --denoise --denoised-png both.png --png raw.png --stats both.json
  present both.png
  present raw.png
  valid_json both.json
  said both.json '"denoise"'
  expect 0 info both.exr
  said out.txt 'denoised\.R'
  said out.txt 'denoised_error\.B'
  said out.txt '^tyndall.denoised_error +0'
  unsaid out.txt 'half|albedo|samples'
  # The raw image is as it was, and so is its PNG.
  expect 0 diff both.exr raw.exr
  said out.txt 'values that differ: 0'
  expect 0 convert raw.exr check.png --curve filmic
  cmp -s check.png raw.png || fail 'the PNG is not of the raw image'
  expect 0 render builtin:cornell_fog --method path -o said.exr --size 24x18 --spp 2 --denoise --denoised-png d.png
  said out.txt '^denoised: relative error .*% by estimate, was '
  said out.txt '^wrote d.png \(denoised\)$'
  expect 0 render builtin:cornell_fog -o auto.exr --size 24x18 --spp 4 -q --denoise --aov depth
  expect 0 info auto.exr
  said out.txt 'depth.Z'
  usage_error '--denoise is for method path, and dom' render builtin:cube_g0 --method dom -o x.exr --denoise
  usage_error '--denoise adds layers to .exr' render builtin:cube_g0 -o x.png --denoise
  usage_error 'give both' render builtin:cube_g0 -o x.exr --denoised-png x.png
  usage_error 'extension is not .png' render builtin:cube_g0 -o x.exr --denoise --denoised-png x.jpg
  usage_error 'two halves of the samples, and there is one' render builtin:cube_g0 --method path --spp 1 --size 8x8 -o x.exr --denoise
}

# By the command, from merged seeds, with features, in a sequence, and resumed.
test_command() {
  draw a --aov all,half --seed 1
  draw b --aov all,half --seed 2
  expect 0 denoise a.exr -o da.exr --png da.png --stats da.json
  said out.txt '^wrote da.png \(denoised\)$'
  valid_json da.json
  said da.json '"parts": 3'
  draw again --denoise --seed 1
  expect 0 convert da.exr la.exr --layer denoised
  expect 0 convert again.exr lb.exr --layer denoised
  expect 0 diff la.exr lb.exr
  said out.txt 'values that differ: 0'
  expect 0 merge a.exr b.exr -o ab.exr -q
  expect 0 denoise ab.exr -o dab.exr --feature da.exr --previous da.exr -q
  expect 0 denoise ab.exr -o dab.exr --previous da.exr
  said out.txt 'by estimate without the previous image'
  expect 0 denoise a.exr -o one.exr -q --threads 1
  cmp -s one.exr da.exr || fail 'the number of threads changes the image'
  expect 0 render builtin:cornell_fog --method path -o r.exr --size 48x36 -q --spp 4 --seed 1 --aov all,half --resume
  expect 0 render builtin:cornell_fog --method path -o r.exr --size 48x36 -q --spp 8 --seed 1 --aov all,half --resume
  expect 0 denoise r.exr -o dr.exr -q
  expect 0 convert dr.exr lr.exr --layer denoised
  expect 0 diff lr.exr la.exr
  said out.txt 'values that differ: 0'
}

test_refusals() {
  draw plain --seed 4
  draw tiny --seed 4 --size 9x9 --aov half
  usage_error 'plain.exr: the image has no channel half.R, ' denoise plain.exr -o x.exr
  usage_error 'missing.exr' denoise missing.exr -o x.exr
  usage_error 'a.exr: denoise.features: 9 x 9 pixels, and the image has 48 x 36' denoise a.exr -o x.exr --feature tiny.exr
  usage_error 'a.exr: denoise.previous: it has no denoised' denoise a.exr -o x.exr --previous b.exr
  usage_error '-o OUT.exr' denoise a.exr
  usage_error 'extension is not .exr' denoise a.exr -o x.png
  usage_error 'extension is not .png' denoise a.exr -o x.exr --png x.jpg
  usage_error '5 images, and there may be 4' denoise a.exr -o x.exr --feature a --feature a --feature a --feature a --feature a
  usage_error 'nowhere' denoise a.exr -o nowhere/x.exr
  absent x.exr
}

test_render
test_command
test_refusals
no_temporary_files
finish 50
