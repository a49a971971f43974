#!/usr/bin/env bash
# tyndall merge from outside; test_merge.c looks at the numbers. usage: test_cli_merge.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

# draw NAME ARGUMENT...: NAME.exr of one scene and size.
draw() {
  name=$1
  shift
  expect 0 render builtin:cornell_fog -o "$name.exr" --size 48x36 -q --aov variance "$@"
}

test_seeds() {
  draw a --spp 8 --seed 1
  draw b --spp 24 --seed 2
  draw c --spp 4 --seed 3
  expect 0 merge a.exr b.exr c.exr -o abc.exr --stats abc.json
  said out.txt '^merged 3 images: 48x36, 36 spp$'
  said out.txt '^wrote abc.exr$'
  valid_json abc.json
  expect 0 info abc.exr
  said out.txt '^tyndall.spp +36$'
  said out.txt '^tyndall.seed +1, 2, 3$'
  said out.txt '^tyndall.error +0'
  said out.txt '^tyndall.complete +1$'
  unsaid out.txt 'samples'
  # In two steps, the other way round.
  expect 0 merge c.exr b.exr -o bc.exr -q
  expect 0 merge bc.exr a.exr -o again.exr -q
  expect 0 diff abc.exr again.exr --json
  said out.txt '"mean_ratio": (1|1\.00000|0\.99999)'
  expect 0 merge a.exr b.exr -o ab.png
  said ab.png 'PNG'
}

test_refusals() {
  draw other --spp 2 --seed 4 -D 'media[0].g=0.3'
  draw plain --spp 2 --seed 5
  expect 0 render builtin:cornell_fog -o rgb.exr --size 48x36 -q --spp 2 --seed 6
  expect 0 render builtin:cornell_fog -o small.exr --size 24x18 -q --spp 2 --seed 7 --aov variance
  usage_error 'a.exr: it shares seed 1 with a.exr' merge a.exr a.exr -o x.exr
  usage_error 'abc.exr: it shares seed 2 with b.exr' merge b.exr abc.exr -o x.exr
  usage_error 'other.exr: tyndall.scene is .*, and that of a.exr' merge a.exr other.exr -o x.exr
  usage_error 'small.exr: the frame is 24 x 18, and that of a.exr is 48 x 36' merge a.exr small.exr -o x.exr
  usage_error 'rgb.exr: the channel variance.. of a.exr is missing' merge a.exr rgb.exr -o x.exr
  usage_error 'there are channels that rgb.exr does not have' merge rgb.exr a.exr -o x.exr
  usage_error 'missing.exr' merge a.exr missing.exr -o x.exr
  usage_error 'expected: tyndall merge A.exr B.exr' merge a.exr -o x.exr
  usage_error '-o OUT.exr' merge a.exr b.exr
  usage_error 'extension' merge a.exr b.exr -o x.jpg
  usage_error 'nowhere' merge a.exr b.exr -o nowhere/x.exr
  head -c 300 a.exr > cut.exr
  usage_error 'cut.exr' merge a.exr cut.exr -o x.exr
  absent x.exr
}

# Pieces of one frame give the frame, bit for bit.
test_crops() {
  draw frame --spp 4 --seed 9
  draw left --spp 4 --seed 9 --crop 0,0,20x36
  draw top --spp 4 --seed 9 --crop 20,0,28x10
  draw rest --spp 4 --seed 9 --crop 20,10,28x26
  expect 0 info rest.exr
  said out.txt '^frame +48x36, from pixel \(20, 10\) on$'
  expect 0 merge left.exr rest.exr top.exr -o pasted.exr
  said out.txt '48x36, 4 spp'
  same frame.exr pasted.exr
  expect 0 info pasted.exr
  said out.txt '^tyndall.spp +4$'
  said out.txt '^tyndall.seed +9$'
  unsaid out.txt 'samples'
  draw middle --spp 4 --seed 10 --crop 10,5,20x20
  expect 0 merge pasted.exr middle.exr -o uneven.exr -q
  expect 0 info uneven.exr
  said out.txt '^samples.N +4 +[0-9.]+ +8$'
  usage_error 'rest.exr: it shares seed 9 with frame.exr' merge frame.exr rest.exr -o x.exr
}

test_seeds
test_refusals
test_crops
no_temporary_files
finish 80
