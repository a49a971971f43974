#!/usr/bin/env bash
# Nothing that goes in can hurt, seen from outside: whatever is wrong with a file, the tool says so in one line that
# names it, exits with 2 and leaves everything on the disk as it was.
# usage: test_cli_malformed.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

# ---- how an input is refused ----

# What is in the folder, but for what the tool printed.
listing() {
  printf '%s\n' ./* kept/*
}

# names FILE CAUSE: one line on stderr that names the file and the cause, nothing on stdout.
names() {
  checks=$((checks + 3))
  message=$(tr '\0' '?' < err.txt)
  [[ $message == "tyndall: "*"$1"* ]] || fail "$1 is not named: ${message:0:300}"
  grep -Eiq -- "$2" <<< "$message" || fail "no cause /$2/: ${message:0:300}"
  [[ -n $message && $message != *$'\n'* && ! -s out.txt ]] ||
    fail "not one line, or something on stdout: ${message:0:300}"
}

# refused FILE CAUSE ARGUMENT...: as above, and nothing on the disk is changed. In the arguments OUT stands for the
# output without its extension: in turn a new file and one that is there.
turn=0
refused() {
  turn=$((turn + 1))
  outputs=(new kept)
  named=$1
  cause=$2
  shift 2
  expect 2 "${@/OUT/${outputs[turn % 2]}}"
  names "$named" "$cause"
  checks=$((checks + 2))
  [ "$(listing)" = "$before" ] || fail "files have come or gone: $(diff <(echo "$before") <(listing))"
  [ "$(cat kept.exr kept.png kept.nrrd)" = "$kept" ] || fail "the file that was there is changed"
}

# The files that a test has made belong to what is there before.
begin() {
  : > out.txt 2> err.txt
  before=$(listing)
}

bad_scene() {
  begin
  refused "$1" "$2" render "$1" -o OUT.exr
  [ $((turn % 4)) -ne 0 ] || refused "$1" "$2" info "$1"
}

# wrong_scene LINE CAUSE TEXT: a scene that is wrong in that line of it.
wrong_scene() {
  printf '%b' "$3" > wrong.json
  bad_scene wrong.json "wrong\.json:$1: .*$2"
}

# What takes images, volumes and meshes, in turn: kinds times two outputs.
kind=0
bad_image() {
  kind=$((kind + 1))
  begin
  case $((kind % 8)) in
  0) refused "$1" "$2" info "$1" ;;
  1) refused "$1" "$2" convert "$1" OUT.png ;;
  2) refused "$1" "$2" diff ok.exr "$1" --png OUT.png ;;
  3) refused "$1" "$2" merge ok.exr "$1" -o OUT.exr ;;
  4) refused "$1" "$2" compare ok.exr "$1" -o OUT ;;
  5) refused "$1" "$2" render sky.json -D "lights[0].file=$1" -o OUT.exr ;;
  6) refused "$1" "$2" screen "$1" -o OUT.exr --medium fog:9 ;;
  7) refused "$1" "$2" screen ok.exr "$1" -o OUT.exr --medium fog:9 ;;
  esac
}

# cut_image FILE SIZES CAUSE: the beginning of it.
cut_image() {
  for size in $2; do
    head -c "$size" "$1" > "cut_$1"
    bad_image "cut_$1" "$3"
  done
}

bad_volume() {
  kind=$((kind + 1))
  begin
  case $((kind % 3)) in
  0) refused "$1" "$2" convert "$1" OUT.nrrd ;;
  1) refused "$1" "$2" render cloud.json -D "media[0].density.file=$1" -o OUT.png ;;
  2) refused "$1" "$2" info "$1" ;;
  esac
}

cut_volume() {
  for size in $2; do
    head -c "$size" "$1" > "cut_$1"
    bad_volume "cut_$1" "$3"
  done
}

# nrrd CAUSE FIELDS [DATA [NAMED]]: a header of those fields, a blank line and the data.
nrrd() {
  { printf 'NRRD0004\n%b\n' "$2"; printf '%b' "${3:-}"; } > bad.nrrd
  begin
  refused "${4:-bad.nrrd}" "$1" convert bad.nrrd OUT.nrrd
}

# bad_mesh FILE CAUSE [NAMED]
bad_mesh() {
  kind=$((kind + 1))
  begin
  case $((kind % 2)) in
  0) refused "${3:-$1}" "$2" info "$1" ;;
  1) refused "${3:-$1}" "$2" render mesh.json -D "geometry[0].file=$1" -o OUT.exr ;;
  esac
}

obj() {
  printf '%b' "$2" > bad.obj
  bad_mesh bad.obj "$1"
}

mtl() {
  printf '%b' "$2" > bad.mtl
  printf 'mtllib bad.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n' > uses.obj
  bad_mesh uses.obj "$1" "$3"
}

# ply CAUSE HEADER [DATA]
ply() {
  { printf 'ply\n%bend_header\n' "$2"; printf '%b' "${3:-}"; } > bad.ply
  bad_mesh bad.ply "$1"
}

# gltf CAUSE MEMBERS [NAMED]: of the outermost object, without its asset.
gltf() {
  printf '{"asset": {"version": "2.0"}, %s}' "$2" > bad.gltf
  bad_mesh bad.gltf "$1" "${3:-}"
}

glb() {
  printf '%b' "$2" > bad.glb
  bad_mesh bad.glb "$1"
}

# ---- what is wrong with it ----

make_good_files() {
  for extension in exr png nrrd; do echo 'what was there before' > kept.$extension; done
  kept=$(cat kept.exr kept.png kept.nrrd)
  mkdir kept folder.exr folder.json folder.vdb folder.nrrd folder.glb
  expect 0 render builtin:cube_g0 -o ok.exr --size 32x32 --spp 1 --aov all -q
  expect 0 convert ok.exr ok.png
  head -c 4096 ok.exr > noise.raw
  for format in vdb nvdb nrrd; do
    expect 0 convert noise.raw "ok.$format" --raw-size 16,16,16 --codec none
    expect 0 convert "ok.$format" "plain.$format"
  done
  expect 0 convert ok.vdb blosc.vdb --codec blosc
  printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n' > ok.hdr
  head -c 16 noise.raw >> ok.hdr
  printf '{"tyndall": 1, "lights": [{"type": "environment", "file": "ok.hdr"}]}' > sky.json
  printf '{"tyndall": 1, "media": [{"density": {"file": "ok.vdb"}, "sigma_t": 1, "albedo": 0.5}]}' \
    > cloud.json
  printf '{"tyndall": 1, "geometry": [{"file": "ok.obj"}]}' > mesh.json
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > ok.obj
  for good in ok.exr ok.png ok.vdb ok.nvdb ok.nrrd ok.hdr ok.obj sky.json cloud.json mesh.json; do
    expect 0 info "$good"
  done
}

test_no_files() {
  mkfifo pipe.exr pipe.json pipe.vdb pipe.nvdb pipe.glb pipe.mtl
  ln -s loop.exr loop.exr
  long=$(printf '%0300d' 0).exr
  begin
  for input in folder.exr folder.json /dev/null /dev/zero missing.exr pipe.exr pipe.json pipe.vdb loop.exr "$long"; do
    none='not a regular file|a folder without DICOM files|No such file|Too many levels|name too long'
    refused "$input" "$none" info "$input"
    refused "$input" "$none" render "$input" -o OUT.exr
  done
  for input in folder.exr missing.exr pipe.exr loop.exr; do
    refused "$input" "$none" convert "$input" OUT.png
    refused "$input" "$none" merge "$input" ok.exr -o OUT.exr
    refused "$input" "$none" diff "$input" ok.exr
    refused "$input" "$none" compare ok.exr "$input" -o OUT
    refused "$input" "$none" render sky.json -D "lights[0].file=$input" -o OUT.exr
  done
  for input in folder.vdb /dev/zero pipe.vdb pipe.nvdb missing.nrrd; do
    refused "$input" "$none" convert "$input" OUT.nrrd --raw-size 1,1,1
    case $input in
    *.*) refused "$input" "$none" render cloud.json -D "media[0].density.file=$input" -o OUT.exr ;;
    esac
  done
  for input in folder.glb pipe.glb missing.obj; do
    refused "$input" "$none" render mesh.json -D "geometry[0].file=$input" -o OUT.exr
  done
  mtl 'not a regular file' 'newmtl a\nmap_Kd folder.exr\n' folder.exr
  mv pipe.mtl bad.mtl
  bad_mesh uses.obj 'not a regular file' bad.mtl
  rm bad.mtl
  odd=$'odd\nname\e[31m.exr'
  begin
  refused 'odd?name?[31m.exr' 'No such file' info "$odd"
  refused 'odd?name?[31m.exr' 'No such file' diff ok.exr "$odd"
  refused 'odd?name?[31m' 'one argument' diff ok.exr ok.exr "$odd"
  if [ "$(id -u)" -ne 0 ]; then
    cp ok.exr locked.exr
    chmod 000 locked.exr
    for _ in 1 2 3 4 5 6; do bad_image locked.exr 'Permission denied'; done
    rm -f locked.exr
  fi
}

test_scenes() {
  : > empty.json
  bad_scene empty.json 'empty'
  for part in vdb glb GLTF exr; do
    echo '{"tyndall": 1}' > "part.$part"
    begin
    refused "part.$part" 'not a scene but an? (volume|mesh|image)' render "part.$part" -o OUT.exr
  done
  wrong_scene 3 'expected' ' \n\n  '
  wrong_scene 1 '' '{"tyndall": 1,'
  wrong_scene 2 '' '{"tyndall": 1,\n "media": [}'
  wrong_scene 1 'tyndall' '{"tyndall": 2}'
  wrong_scene 1 'tyndall' '{"tyndall": "1"}'
  wrong_scene 1 'tyndall' '{}'
  wrong_scene 1 '' '[]'
  wrong_scene 2 'end of file' '{"tyndall": 1}\n{}'
  wrong_scene 3 'did you mean "media"' '{"tyndall": 1,\n\n "medai": []}'
  wrong_scene 2 'duplicate' '{"tyndall": 1,\n "tyndall": 1}'
  wrong_scene 2 'camera' '{"tyndall": 1,\n "camera": 5}'
  wrong_scene 2 '' '{"tyndall": 1,\n "meters_per_unit": NaN}'
  wrong_scene 2 '' '{"tyndall": 1,\n "meters_per_unit": 1e999}'
  wrong_scene 2 'decode' '{"tyndall": 1,\n "camera": {"name": "\xff\xfe"}}'
  wrong_scene 2 '' '{"tyndall": 1,\n \0 "media": []}'
  wrong_scene 1 '' '\xff\xfe{\0}\0'
  wrong_scene 2 'spp' '{"tyndall": 1,\n "render": {"spp": 10000000000}}'
  wrong_scene 2 'spp' '{"tyndall": 1,\n "render": {"spp": 0}}'
  wrong_scene 2 'resolution' '{"tyndall": 1,\n "camera": {"resolution": [0, 5]}}'
  wrong_scene 2 'resolution' '{"tyndall": 1,\n "camera": {"resolution": [1000000000, 1000000000]}}'
  wrong_scene 3 'sigma_t' '{"tyndall": 1,\n "media": [\n {"sigma_t": -1}]}'
  wrong_scene 2 'g' '{"tyndall": 1,\n "media": [{"sigma_t": 1, "albedo": 0, "g": 1.2}]}'
  wrong_scene 2 'radiance' '{"tyndall": 1,\n "lights": [{"type": "environment", "radiance": [1, 2]}]}'
  wrong_scene 2 'type' '{"tyndall": 1,\n "lights": [{"type": "laser"}]}'
  wrong_scene 3 'resolution' '{"tyndall": 1,\n "media": [{"sigma_t": 1,
    "albedo": 0, "density": {"noise": {"resolution": 100000}}}]}'
  wrong_scene 3 'missing.nrrd' '{"tyndall": 1,\n "media": [{"sigma_t": 1,
    "albedo": 0, "density": {"file": "missing.nrrd"}}]}'
  head -c 200000 /dev/zero | tr '\0' '[' > deep.json
  bad_scene deep.json 'deep'
  dd if=/dev/zero of=large.json bs=1 count=1 seek=2147483648 2> /dev/null
  begin
  refused large.json 'limit' render large.json -o OUT.exr
  rm large.json
}

test_images() {
  cp ok.png text.exr
  printf 'neither this nor that' > text.exr
  bad_image text.exr 'neither'
  : > empty.exr
  bad_image empty.exr 'empty'
  size=$(wc -c < ok.exr)
  cut_image ok.exr "4 8 100 400 $((size - 1))" '.'
  cut_image ok.png "8 20 40 $(($(wc -c < ok.png) - 20))" '.'
  cut_image ok.hdr "2 20 $(($(wc -c < ok.hdr) - 1))" '.'
  { head -c 4 ok.exr; printf '\011'; tail -c +6 ok.exr; } > version.exr
  bad_image version.exr 'version'
  { head -c 8 ok.exr; tail -c 3000 ok.exr; } > mixed.exr
  bad_image mixed.exr '.'
  { head -c 16 ok.png; printf '\177\377\377\377\177\377\377\377'; tail -c +25 ok.png; } > huge.png
  bad_image huge.png '.'
  { head -c 50 ok.png; printf 'X'; tail -c +52 ok.png; } > damaged.png
  bad_image damaged.png '.'
  printf '#?RADIANCE\n\n-Y 60000 +X 60000\n' > huge.hdr
  bad_image huge.hdr '.'
  printf '#?RADIANCE\n\n-Y -1 +X 99999999999\n' > size.hdr
  bad_image size.hdr '.'
  printf '\xff\xd8\xff' > start.jpg
  bad_image start.jpg '.'
  printf '\xff\xd8\xff\xc0\0\x11\x08\xff\xff\xff\xff\x03\1\x11\0\2\x11\0\3\x11\0\xff\xd9' > huge.jpg
  bad_image huge.jpg '.'
  begin
  refused ok.png 'variance|samples|R|spp' merge ok.exr ok.png -o OUT.exr
  expect 0 render builtin:cube_g0 -o other.exr --size 8x8 --spp 1 -q
  begin
  refused other.exr '16 x 16 and 8 x 8|32 x 32 and 8 x 8' diff ok.exr other.exr --png OUT.png
}

test_volumes() {
  for format in vdb nvdb nrrd; do
    size=$(wc -c < "ok.$format")
    cut_volume "ok.$format" "4 7 12 60 300 1000 $((size / 2)) $((size - 1))" '.'
    cut_volume "plain.$format" "$(($(wc -c < "plain.$format") - 9))" '.'
    cp ok.obj "text.$format"
    begin
    refused "text.$format" '.' convert "text.$format" OUT.nrrd
    : > "empty.$format"
    bad_volume "empty.$format" '.'
  done
  # `info` lists the arrays of a .vti file without reading them.
  expect 0 convert noise.raw ok.vti --raw-size 16,16,16 --codec none
  cut_volume ok.vti '4 7 60 300 400 500' '.'
  head -c 5000 ok.vti > cut_ok.vti
  begin
  refused cut_ok.vti 'damaged or cut short' convert cut_ok.vti OUT.nrrd
  for format in vti vtk nc; do
    cp ok.obj "text.$format"
    bad_volume "text.$format" '.'
    : > "empty.$format"
    bad_volume "empty.$format" '.'
  done
  cut_volume blosc.vdb "$(($(wc -c < blosc.vdb) - 100))" '.'
  { head -c 8 ok.vdb; printf '\1\0\0\0'; tail -c +13 ok.vdb; } > old.vdb
  bad_volume old.vdb 'format 1'
  { head -c 600 ok.vdb; head -c 600 /dev/zero | tr '\0' '\377'; tail -c +1201 ok.vdb; } > damaged.vdb
  bad_volume damaged.vdb '.'
  { head -c 8 ok.nvdb; printf '\377\377\377\377'; tail -c +13 ok.nvdb; } > version.nvdb
  bad_volume version.nvdb '.'
  : > empty.raw
  begin
  refused ok.vdb 'no grid "smoke"' convert ok.vdb OUT.nrrd --grid smoke
  refused noise.raw 'size' convert noise.raw OUT.nrrd
  refused noise.raw '16384 x 16384' convert noise.raw OUT.nrrd --raw-size 16384,16384,16384 --raw-type double
  refused noise.raw '4096 bytes' convert noise.raw OUT.nrrd --raw-size 1,1,1
  refused noise.raw '4096 bytes' info noise.raw --raw-size 16,16,17
  refused empty.raw '0 bytes|empty' convert empty.raw OUT.nrrd --raw-size 1,1,1
}

test_nrrds() {
  fields='type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n'
  printf 'NRRD0009\n%b\n' "$fields" > version.nrrd
  bad_volume version.nrrd 'version'
  nrrd 'missing' ''
  nrrd 'sizes' 'type: uint8\ndimension: 3\nencoding: raw\n' 12345678
  nrrd 'sizes' 'type: uint8\ndimension: 3\nsizes: 2 0 2\nencoding: raw\n' 12345678
  nrrd 'sizes' 'type: uint8\ndimension: 3\nsizes: 2 -2 2\nencoding: raw\n' 12345678
  nrrd '16384 x 16384' 'type: double\nendian: little\ndimension: 3\nsizes: 16384 16384 16384\nencoding: raw\n' 12345678
  nrrd '4294967297 x' 'type: uint8\ndimension: 3\nsizes: 4294967297 4294967297 2\nencoding: raw\n' 12345678
  nrrd 'type' 'type: complex\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n' 12345678
  nrrd 'dimension' 'type: uint8\ndimension: 17\nsizes: 2 2 2\nencoding: raw\n' 12345678
  nrrd 'encoding' 'type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: bzip2\n' 12345678
  nrrd 'endian' 'type: float\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n' 12345678
  nrrd 'bytes|short' "$fields" 1234567
  nrrd 'bytes|more' "$fields" 123456789
  nrrd '.' 'type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n' 12345678
  nrrd '.' 'type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: text\n' '1 2 3 x'
  nrrd 'missing.raw' "${fields}data file: missing.raw\n" '' missing.raw
  nrrd '.' "${fields}data file: /etc/passwd\n"
  nrrd '.' "${fields}data file: ../secret.raw\n"
  nrrd '.' "${fields}data file: folder.exr\n" '' folder.exr
  nrrd '.' "${fields}space dimension: 3\nspace directions: (nan,0,0) (0,1,0) (0,0,1)\n" 12345678
  nrrd '.' "${fields}space dimension: 3\nspace directions: (0,0,0) (0,0,0) (0,0,0)\n" 12345678
}

test_meshes() {
  obj 'bad.obj:2: ' 'v 0 0 0\nf 1 2 3\n'
  obj 'bad.obj:4: ' 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n'
  obj 'bad.obj:1: ' 'v 0 zero 0\n'
  obj 'bad.obj:1: ' 'v 0 nan 0\n'
  obj 'bad.obj:1: ' 'v 0 1e999 0\n'
  obj 'no faces' 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n'
  obj 'bad.obj:4: ' 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n'
  obj 'out of' 'mtllib ../up.mtl\nv 0 0 0\n'
  mtl 'bad.mtl:2: ' 'newmtl a\nKd red\n' bad.mtl
  mtl 'missing.png' 'newmtl a\nmap_Kd missing.png\n' missing.png
  mtl '.' 'newmtl a\nmap_Kd cut_ok.png\n' cut_ok.png
  mtl 'relative' 'newmtl a\nmap_Kd /etc/passwd\n' bad.mtl
  vertices='format ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n'
  faces='element face 1\nproperty list uchar int vertex_indices\n'
  ply '.' ''
  ply 'format|version' 'format ascii 2.0\n'
  ply 'format' 'format binary_middle_endian 1.0\n'
  ply '.' 'format ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\n'
  ply '.' "$vertices$faces" '0 0 0\n1 0 0\n'
  ply '.' "$vertices$faces" '0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n'
  ply '.' "$vertices$faces" '0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n'
  ply '.' "$vertices$faces" '0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n'
  ply '.' 'format ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n' '0 0\n'
  ply '.' 'format ascii 1.0\nelement vertex 3\nproperty string x\n' '0\n'
  printf 'ply\nformat ascii 1.0\n' > cut.ply
  bad_mesh cut.ply '.'
}

test_gltf() {
  : > empty.gltf
  bad_mesh empty.gltf 'empty|neither'
  printf '{"asset": {"version": "1.0"}}' > version.gltf
  bad_mesh version.gltf 'version "1.0"'
  printf '{"scenes": []}' > plain.gltf
  bad_mesh plain.gltf 'asset.version'
  printf '{\n"asset":' > cut.gltf
  bad_mesh cut.gltf 'cut.gltf:2: '
  gltf 'requires' '"extensionsRequired": ["KHR_techniques_webgl"]'
  gltf 'nodes\[0\]' '"nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]'
  gltf 'mesh' '"nodes": [{"mesh": 3}], "scenes": [{"nodes": [0]}]'
  triangle='"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],'
  positions='"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]'
  gltf 'missing.bin' "$triangle $positions, \"buffers\": [{\"uri\": \"missing.bin\", \"byteLength\": 36}]" missing.bin
  gltf 'out of' "$triangle $positions, \"buffers\": [{\"uri\": \"../up.bin\", \"byteLength\": 36}]"
  gltf 'relative' "$triangle $positions, \"buffers\": [{\"uri\": \"file:///etc/passwd\", \"byteLength\": 36}]"
  gltf 'buffers\[0\]' "$triangle $positions, \"buffers\": [{\"uri\": \"data:;base64,AAAA\", \"byteLength\": 36}]"
  gltf 'buffers\[0\]' "$triangle $positions, \"buffers\": [{\"uri\": \"data:;base64,%%%%\", \"byteLength\": 3}]"
  gltf '.' "$triangle \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4000000000,
    \"type\": \"VEC3\"}], \"buffers\": [{\"uri\": \"noise.raw\", \"byteLength\": 36}]"
  glb '.' 'glTF'
  glb 'version 1' 'glTF\1\0\0\0\x0c\0\0\0'
  glb 'cut short' 'glTF\2\0\0\0\xff\xff\xff\x7f'
  glb 'JSON chunk' 'glTF\2\0\0\0\x0c\0\0\0'
  glb 'past the end' 'glTF\2\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON'
}

# resumed CAUSE: the state that new.exr and kept.exr would go on from.
resumed() {
  cp bad.state new.exr.state
  cp bad.state kept.exr.state
  begin
  refused .exr.state "$1" render builtin:cube_g0 --size 16x16 --spp 2 -o OUT.exr --resume
  checks=$((checks + 1))
  cmp -s bad.state kept.exr.state || fail "the state was changed"
}

test_states() {
  expect 0 render builtin:cube_g0 --size 16x16 --spp 1 -o good.exr --resume -q
  : > bad.state
  resumed 'cut short'
  head -c 50 good.exr.state > bad.state
  resumed 'cut short'
  head -c -1 good.exr.state > bad.state
  resumed 'cut short'
  { cat good.exr.state; printf x; } > bad.state
  resumed '.'
  cp noise.raw bad.state
  resumed 'not the state'
  { head -c 8 good.exr.state; printf '\377'; tail -c +10 good.exr.state; } > bad.state
  resumed '.'
  rm -f new.exr.state kept.exr.state
  mkdir new.exr.state kept.exr.state
  begin
  refused .exr.state 'not a file|regular' render builtin:cube_g0 --size 16x16 --spp 2 -o OUT.exr --resume
}

make_good_files
test_no_files
test_scenes
test_images
test_volumes
test_nrrds
test_meshes
test_gltf
test_states
no_temporary_files
finish 1000
