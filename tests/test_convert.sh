#!/usr/bin/env bash
# tyndall convert and info on volumes and images from outside: conversions there and back, messages, exit statuses.
# usage: test_convert.sh TYNDALL DATA (works in the current folder, which it empties; DATA may be missing)
. "$(dirname "$0")/cli.sh"
data=${TYNDALL_DATA:-$2}

# identical A B: two files hold the same bytes.
identical() {
  checks=$((checks + 1))
  cmp -s "$1" "$2" || fail "$1 and $2 differ"
}

test_raw_through_every_format() {
  printf 'abcdefghijklmnopqrstuvwx' > letters.raw
  expect 0 convert letters.raw a.nrrd --raw-size 2,3,4 --raw-spacing 1,2,0.5 --codec none
  expect 0 convert a.nrrd b.vdb
  expect 0 convert b.vdb c.nvdb
  expect 0 convert c.nvdb d.nrrd --codec none
  identical a.nrrd d.nrrd
  expect 0 info d.nrrd
  said out.txt '^size +2x3x4$'
  said out.txt '^range +97 to 120, mean 108.5$'
  said out.txt '^index to place +1 0 0 \+0$'
  expect 0 info letters.raw --raw-size 2,3,4
  said out.txt '^values .*half when read'
  expect 0 info c.nvdb
  said out.txt '^density +float +24 active voxels'
  expect 0 info a.nrrd --json
  said out.txt '"index_to_local"'
}

# Bricks hold the same grid; their head and its size are checked.
test_bricks() {
  printf 'abcdefghijklmnopqrstuvwx' > letters.raw
  expect 0 convert letters.raw e.bricks --raw-size 2,3,4 --raw-spacing 1,2,0.5
  expect 0 convert letters.raw f.nrrd --raw-size 2,3,4 --raw-spacing 1,2,0.5 --codec none
  expect 0 convert e.bricks g.nrrd --codec none
  identical f.nrrd g.nrrd
  expect 0 info e.bricks
  said out.txt '^values +1 per voxel, half when read, paged, with tables of '
  said out.txt '^range +97 to 120, mean 108.5$'
  expect 0 info e.bricks --json
  said out.txt '"storage": "paged"'
  usage_error "codec 'zip' is not one of none" convert letters.raw e.bricks --raw-size 2,3,4 --codec zip
  head -c 9000 e.bricks > short.bricks
  usage_error 'short.bricks: 9000 bytes, of which its head accounts for' info short.bricks
  TMPDIR=$PWD/no usage_error 'cannot write .* bytes of paged arrays to .*/no: No such file' convert letters.raw h.bricks --raw-size 2,3,4
  absent h.bricks
}

# dicom FILE Z FIRST: a slice of 2 x 1 samples FIRST and FIRST + 1 (bytes), 3 mm wide pixels, at a height of Z (a digit).
dicom() {
  { head -c 128 /dev/zero
    printf 'DICM\2\0\20\0UI\24\0001.2.840.10008.1.2.1\0'
    printf '\10\0\140\0CS\2\0MR'
    printf '\40\0\16\0UI\4\0001.2\0\40\0\21\0IS\2\0007 \40\0\62\0DS\6\0000\\0\\%s ' "$2"
    printf '\40\0\67\0DS\14\0001\\0\\0\\0\\1\\0 '
    printf '\50\0\20\0US\2\0\1\0\50\0\21\0US\2\0\2\0\50\0\60\0DS\4\0003\\3 '
    printf '\50\0\0\1US\2\0\10\0\50\0\1\1US\2\0\10\0\50\0\2\1US\2\0\7\0\50\0\3\1US\2\0\0\0'
    printf '\50\0\122\20DS\4\000-10 '
    printf '\340\177\20\0OB\0\0\2\0\0\0'
    printf "\\x$(printf %x "$3")\\x$(printf %x $(($3 + 1)))"; } > "$1"
}

test_scans() {
  mkdir head
  dicom head/one 5 60
  dicom head/two 1 40
  expect 0 info head
  said out.txt '^format +DICOM, not compressed, 8 bits unsigned$'
  said out.txt '^modality +MR$'
  said out.txt '^slices +2 in 2 files$'
  said out.txt '^spacing +3 x 3 x 4 mm$'
  said out.txt '^size +2x1x2$'
  said out.txt '^range +30 to 51, '
  said out.txt '^ +0 0 4 \+1$'
  expect 0 info head/one --json
  said out.txt '"modality": "MR"'
  valid_json out.txt
  expect 0 convert head a.nrrd --codec none
  expect 0 convert head/two b.nrrd --codec none
  identical a.nrrd b.nrrd
  expect 0 convert head c.vdb
  dicom head/three 9 80
  dicom head/four 9 90
  usage_error 'head: four and three lie at the same position' info head
  usage_error 'head: four and three lie' convert head a.nrrd
  dicom head/four 3 90
  usage_error 'head: .* are [24] mm apart, where others are [24] mm' info head
  usage_error 'no series "9"; there is 7 "" \(4 files, 1.2\)' info head --series 9
  head -c 300 head/one > cut.dcm
  usage_error 'cut.dcm: cut short' info cut.dcm
  mkdir none
  usage_error 'none: a folder without DICOM files' info none
  printf 'VOL\3\1\0\0\0\2\0\0\0\1\0\0\0\1\0\0\0\1\0\0\0' > a.vol
  printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\200\77\0\0\200\77' >> a.vol
  printf '\0\0\0\0\0\0\0\100' >> a.vol # 0 and 2
  expect 0 info a.vol
  said out.txt '^format +Mitsuba .vol, version 3, float$'
  said out.txt '^range +0 to 2, mean 1$'
  expect 0 convert a.vol a.nrrd
  expect 0 convert a.nrrd b.vol
  identical a.vol b.vol
  printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspace dimension: 3\n' > turned.nrrd
  printf 'space directions: (0,1,0) (1,0,0) (0,0,1)\n\nx' >> turned.nrrd
  usage_error 'is turned or reversed' convert turned.nrrd c.vol
  printf 'II*\0\10\0\0\0\0\0' > a.tif
  usage_error 'a.tif: ' info a.tif
}

# The same through VTK's formats, and three values per voxel as vectors of floats and of halves.
test_vtk() {
  printf 'abcdefghijklmnopqrstuvwx' > letters.raw
  expect 0 convert letters.raw a.nrrd --raw-size 2,3,4 --raw-spacing 1,2,0.5 --codec none
  expect 0 convert a.nrrd b.vti
  expect 0 convert b.vti c.nrrd --codec none
  identical a.nrrd c.nrrd
  expect 0 info b.vti
  said out.txt '^density +float +24 active voxels in .0, 0, 0. to .1, 2, 3., voxel 1 x 2 x 0.5'
  expect 0 info b.vti --grid density
  said out.txt '^range +97 to 120, mean 108.5$'
  printf '# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\nPOINT_DATA 2
VECTORS v float\n1 2 3 4 5 6\n' > v.vtk
  expect 0 convert a.nrrd n.nii.gz
  expect 0 convert n.nii.gz d.nrrd --codec none
  identical a.nrrd d.nrrd
  expect 0 info n.nii.gz
  said out.txt '^format +NIfTI-1, float$'
  expect 0 convert v.vtk n.nii --vector --grid v
  expect 0 info n.nii --component 2
  said out.txt '^range +3 to 6, mean 4.5$'
  expect 0 convert v.vtk v.vdb --vector --half --grid v
  expect 0 info v.vdb
  said out.txt '^v +vec3s +2 active voxels'
  expect 0 convert v.vdb w.vti --vector --grid v --codec none
  expect 0 info w.vti --grid v --component 2
  said out.txt '^range +3 to 6, mean 4.5$'
  expect 0 convert a.nrrd half.vdb --half
  expect 0 info half.vdb
  said out.txt '^density +half '
  usage_error 'no array "w"; there is v' convert v.vtk a.vdb --grid w
  usage_error '3 values per voxel; component 3' convert v.vtk a.vdb --component 3
  usage_error '1 values per voxel, not 3' convert a.nrrd a.vdb --vector
  usage_error 'vector is for .vdb, .vti and .nii' convert v.vtk a.nrrd --vector
  usage_error 'half is for .vdb' convert a.nrrd b.vti --half
  usage_error "codec 'blosc'" convert a.nrrd b.vti --codec blosc
  usage_error 'air-density goes with' convert v.vtk a.vdb --air-density 1
  usage_error 'neither a name nor' convert v.vtk a.vdb --effective-radius 0
  usage_error 'grid is for volumes of named grids' info a.nrrd --grid density
}

test_messages() {
  printf 'abcdefgh' > eight.raw
  usage_error 'needs its size' convert eight.raw a.vdb
  usage_error '8 bytes; 2 x 2 x 3' convert eight.raw a.vdb --raw-size 2,2,3
  usage_error 'raw-size' convert eight.raw a.vdb --raw-size 2,2
  usage_error 'raw-size' convert eight.raw a.vdb --raw-size 2,2,1.5
  usage_error 'raw_type is "bits"' convert eight.raw a.vdb --raw-size 2,2,2 --raw-type bits
  usage_error 'goes to .vdb, .nvdb, .nrrd, .vti, .nii, .nii.gz, .vol or .bricks' convert eight.raw a.txt --raw-size 2,2,2
  usage_error "codec 'lzma'" convert eight.raw a.vdb --raw-size 2,2,2 --codec lzma
  usage_error "codec 'blosc'" convert eight.raw a.nvdb --raw-size 2,2,2 --codec blosc
  usage_error 'No such file' convert gone.vdb a.nrrd
  usage_error 'no/such' convert eight.raw no/such/a.vdb --raw-size 2,2,2
  expect 0 convert eight.raw a.vdb --raw-size 2,2,2
  usage_error 'no grid "smoke"; there is density' convert a.vdb b.nrrd --grid smoke
  usage_error 'component 1' convert a.vdb b.nrrd --component 1
}

test_images() {
  expect 0 render builtin:cube_g0 --size 16x12 --spp 1 -o a.exr
  expect 0 convert a.exr b.exr
  expect 0 diff a.exr b.exr
  said out.txt '^values that differ: 0$'
  expect 0 convert a.exr a.png --exposure 1 --curve filmic
  expect 0 convert a.exr depth.png --bits 16 --channel G --scale 1000
  usage_error "no channel 'Z'" convert a.exr depth.png --bits 16 --channel Z
  usage_error 'goes to .exr, .png, .ktx2 or .dds' convert a.exr a.vdb
  usage_error 'for .png' convert a.exr b.exr --bits 16
  usage_error 'neither 8 nor 16' convert a.exr a.png --bits 12
}

test_real_volumes() {
  cloud="$data/volumes/wdas_cloud_sixteenth.vdb"
  [ -r "$cloud" ] || { echo "skipped: no $cloud (set TYNDALL_DATA)"; return; }
  expect 0 convert "$cloud" cloud.nrrd --codec none
  expect 0 convert cloud.nrrd cloud.vdb
  expect 0 convert cloud.vdb again.nrrd --codec none
  expect 0 info again.nrrd
  said out.txt '^range +0 to 1, '
  expect 0 convert "$data/volumes/plume/plume_####.vdb" velocity.nrrd --frame 42 --grid velocity --component 2
  usage_error 'plume_0043' convert "$data/volumes/plume/plume_####.vdb" velocity.nrrd --frame 43
}

test_bench() {
  expect 0 bench load --side 16 --runs 1
  for name in 'vdb none float' 'vdb blosc half' 'nvdb zip' 'nrrd gzip'; do said out.txt "^  $name.*:$"; done
  expect 0 bench load --side 16 --runs 1 --json
  said out.txt '"mvoxels_per_second"'
}

for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
no_temporary_files
finish 60
