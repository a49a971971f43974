#!/usr/bin/env bash
# tyndall fluence: volumes of fluence by every method that has it, their places, and what is refused.
# usage: test_cli_fluence.sh TYNDALL (works in the current folder, which it empties)
. "$(dirname "$0")/cli.sh"

# mean FILE GRID: the mean of the green channel.
mean() {
  "$tyndall" info "$1" --grid "$2" --component 1 | sed -n 's/.*mean //p'
}

# near A B FRACTION: two numbers differ by less than a fraction of the second.
near() {
  checks=$((checks + 1))
  awk -v a="$1" -v b="$2" -v f="$3" 'BEGIN { exit !(a > 0 && a - b < f * b && b - a < f * b) }' || fail "$1 is not within $3 of $2"
}

# Measured: dom 0.1 % and fld 0.05 % from path, whose own noise is 0.2 %.
test_methods_agree() {
  for method in path dom fld; do
    expect 0 fluence builtin:cube_g0 -o $method.vti --method $method --size 8,8,8 --spp 200
    said out.txt "^wrote $method.vti: 8 x 8 x 8 cells by $method"
  done
  near "$(mean dom.vti fluence)" "$(mean path.vti fluence)" 0.01
  near "$(mean fld.vti fluence)" "$(mean path.vti fluence)" 0.01
  near "$(mean dom.vti uncollided)" "$(mean path.vti uncollided)" 0.001
  expect 0 info dom.vti
  said out.txt '^fluence +float\[3\] +512 active voxels in .0, 0, 0. to .7, 7, 7., voxel 0.125 x 0.125 x 0.125'
  expect 0 info dom.vti --grid uncollided
  said out.txt '^index to place +0.125 0 0 -0.4375$'
}

test_boxes() {
  expect 0 fluence builtin:cube_g0 -o part.vdb --method fld --box -0.5,-0.5,-0.5,0,0.5,0.5 --size 2,4,4 --half --codec blosc
  expect 0 info part.vdb --grid fluence
  said out.txt '^size +2x4x4$'
  said out.txt '^values +3 per voxel, half'
  said out.txt '^index to place +0.25 0 0 -0.375$'
  expect 0 convert part.vdb again.vti --grid fluence --vector
}

test_messages() {
  usage_error 'o FILE is missing' fluence builtin:cube_g0
  usage_error 'extension is not .vti, .vdb, .ktx2 or .dds' fluence builtin:cube_g0 -o a.nrrd
  usage_error 'texture and --scattered are for .ktx2 and .dds' fluence builtin:cube_g0 -o a.vti --texture fluence
  usage_error 'texture phase is of --method dom' fluence builtin:cube_g0 -o a.ktx2 --texture phase --method path
  usage_error 'leaves out uncollided light anyway' fluence builtin:cube_g0 -o a.ktx2 --texture phase --scattered
  usage_error 'half is for .vdb' fluence builtin:cube_g0 -o a.vti --half
  usage_error "'8,8' is not X,Y,Z" fluence builtin:cube_g0 -o a.vti --size 8,8
  usage_error "'8,8,8.5' is not X,Y,Z" fluence builtin:cube_g0 -o a.vti --size 8,8,8.5
  usage_error "'0,0,0,1,1,0' is not" fluence builtin:cube_g0 -o a.vti --box 0,0,0,1,1,0
  usage_error "'lpv' is none of" fluence builtin:cube_g0 -o a.vti --method lpv
  usage_error 'No such file' fluence gone.json -o a.vti
  usage_error 'codec is for .vti and .vdb' fluence builtin:cube_g0 -o a.ktx2 --codec zip
  usage_error "codec 'gzip' is not one of zip, none" fluence builtin:cube_g0 -o a.vti --codec gzip
  usage_error "codec 'gzip' is not one of zip, blosc, none" fluence builtin:cube_g0 -o a.vdb --codec gzip
  usage_error 'no media, and so no box' fluence empty.json -o a.vti
}

# Textures: all light is the uncollided and the other, by the means of their channels.
mean_of_texture() {
  python3 -c 'import struct, sys
data = open(sys.argv[1], "rb").read()
at, count = struct.unpack_from("<QQ", data, 80)
halves = struct.unpack_from("<%de" % (count // 2), data, at)
print(sum(halves[1::4]) / (count // 8), sum(halves[3::4]) / (count // 8))' "$1"
}

test_textures() {
  expect 0 fluence builtin:cube_g0 -o all.ktx2 --size 6,6,6 --no-zstd --texture fluence
  said all.json '"quantity": "fluence"'
  expect 0 fluence builtin:cube_g0 -o rest.ktx2 --size 6,6,6 --no-zstd --texture fluence --scattered
  said rest.json 'all but uncollided'
  expect 0 fluence builtin:cube_g0 -o cells.vti --size 6,6,6
  set -- $(mean_of_texture all.ktx2) $(mean_of_texture rest.ktx2)
  near "$1" "$(mean cells.vti fluence)" 0.001
  near "$(python3 -c "print($1 - $3)")" "$(mean cells.vti uncollided)" 0.002
  expect 0 fluence builtin:cube_g0 -o a.dds --size 6,6,6
  # Light in two parts is the whole: uncollided light that is scattered evenly, and all other.
  expect 0 fluence builtin:cube_g0 -o whole.ktx2 --size 6,6,6 --no-zstd
  expect 0 fluence builtin:cube_g0 -o parts.ktx2 --size 6,6,6 --no-zstd --texture phase
  said parts.json '"texture": "parts_directions.ktx2"'
  said parts.json 'approximated: directions: those of luminance'
  set -- $(mean_of_texture whole.ktx2) $(mean_of_texture parts.ktx2) $(mean_of_texture parts_uncollided.ktx2)
  near "$(python3 -c "import math; print($3 + $5 / 4 / math.pi)")" "$1" 0.002
}

echo '{"tyndall": 1}' > empty.json
for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
no_temporary_files
finish 37
