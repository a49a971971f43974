#!/usr/bin/env bash
# tyndall compare from outside. usage: test_cli_compare.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

test_scene() {
  expect 0 compare builtin:cube_g0 --methods path,path -o new --size 40x30 --spp 4 --reference-spp 64 --seed 3 \
    --stats stats.json
  said out.txt '^path +[01]\.[0-9]+'
  said out.txt '^path-2 +[01]\.[0-9]+'
  for file in errors.json table.md side.png heat_path.png heat_path-2.png path.exr path-2.exr reference.exr; do
    present "new/$file"
  done
  valid_json new/errors.json
  valid_json stats.json
  said stats.json '"scene": "builtin:cube_g0"'
  said new/errors.json '"relative_rmse": 0\.[0-9]'
  said new/errors.json '"spp": 64'
  said new/table.md '^\| path-2 \| all \| [01]\.?[0-9]* \|'
  said new/side.png 'PNG'
  same new/path.exr new/path-2.exr
  expect 0 info new/reference.exr
  said out.txt '^tyndall.seed +4$'
  # The same reference again: the numbers are the same, and files are replaced.
  cp new/errors.json before.json
  expect 0 compare builtin:cube_g0 --methods path -o new --spp 4 --seed 3 --reference new/reference.exr -q
  checks=$((checks + 1))
  [ "$(grep -m 1 rel_mse new/errors.json)" = "$(grep -m 1 rel_mse before.json)" ] || fail "other errors than before"
}

test_images() {
  cp new/path.exr 'odd name.exr'
  expect 0 compare new/reference.exr new/path.exr 'odd name.exr' new/reference.exr -o images --exposure 1
  said out.txt '^odd_name '
  said out.txt '^reference-2 +1 +0 +0 +0$'
  present images/heat_odd_name.png
  said images/table.md '^\| reference-2 \| G \| 1 \| 0 \| 0 \| 0 \| 64 \|'
  # As `tyndall diff` says.
  expect 0 diff new/path.exr new/reference.exr --json
  rmse=$(grep -m 1 '"rmse"' out.txt | tr -d ' ,')
  checks=$((checks + 1))
  tr -d ' ,' < images/errors.json | grep -qF "$rmse" || fail "diff says $rmse, compare does not"
}

test_refusals() {
  usage_error "unknown method 'fog'; known: path" compare builtin:cube_g0 --methods path,fog -o x
  usage_error 'which methods' compare builtin:cube_g0 -o x
  usage_error '-o DIR' compare builtin:cube_g0 --methods path
  usage_error 'one argument too many' compare builtin:cube_g0 new/path.exr --methods path -o x
  usage_error 'what to compare with' compare new/path.exr -o x
  usage_error 'only --exposure goes with finished images' compare new/path.exr new/path.exr --spp 3 -o x
  usage_error '--reference-spp' compare builtin:cube_g0 --methods path --reference new/path.exr --reference-spp 9 -o x
  usage_error 'a/b' compare builtin:cube_g0 --methods path -o a/b
  touch plain
  usage_error 'plain' compare builtin:cube_g0 --methods path -o plain
  absent x
  expect 0 render builtin:cube_g0 -o small.exr --size 8x8 --spp 1 -q
  usage_error 'small.exr and new/path.exr' compare new/path.exr small.exr -o x
  usage_error 'missing.exr' compare builtin:cube_g0 --methods path --reference missing.exr -o x
  usage_error 'cube_g7' compare builtin:cube_g7 --methods path -o x
  absent x
}

test_interrupt() {
  start compare builtin:cornell_fog --methods path -o cut --size 64x48 --spp 100000
  kill -INT "$process"
  finished 130
  absent cut/errors.json
}

test_scene
test_images
test_refusals
test_interrupt
no_temporary_files
finish 60
