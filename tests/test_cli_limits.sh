#!/usr/bin/env bash
# Names of files, outputs that are inputs, limits of the shell, and inputs far too large. usage: test_cli_limits.sh TYNDALL
# (empties the current folder)
. "$(dirname "$0")/cli.sh"

# one_line PATTERN: err.txt is one line that matches.
one_line() {
  checks=$((checks + 1))
  [ "$(wc -l < err.txt)" -eq 1 ] || fail "not one line: $(head -c 500 err.txt)"
  said err.txt "^tyndall: .*$1"
}

# limited STATUS PATTERN LIMIT ARGUMENT...: under `ulimit LIMIT`, one line; or none, if the status is 0.
limited() {
  wanted=$1
  pattern=$2
  limit=$3
  shift 3
  what="ulimit $limit; tyndall $*"
  # shellcheck disable=SC2086
  (exec > out.txt 2> err.txt < /dev/null && ulimit $limit && exec "$tyndall" "$@")
  status=$?
  checks=$((checks + 1))
  [ "$status" -eq "$wanted" ] || fail "exit status $status instead of $wanted: $(head -c 500 err.txt)"
  [ "$wanted" -eq 0 ] || one_line "$pattern"
}

small() {
  expect 0 render builtin:cube_g0 --size 16x16 --spp 1 -q "$@"
}

test_names() {
  small -o plain.exr
  for name in 'with blanks.exr' $'with\nnewlines.exr' './-dash.exr' 'Über 雾.exr' "quo'te\"s\$(x).exr" \
    "$(printf '%0251d' 0).exr"; do
    small -o "$name"
    expect 0 diff plain.exr "$name"
    expect 0 info -- "$name"
    expect 0 convert "$name" out.png
    rm "$name"
  done
  small -o ./-dash.exr
  expect 0 diff -- -dash.exr plain.exr
  expect 0 merge ./-dash.exr plain.exr -o merged.exr --help
  rm -- -dash.exr
  long=$(printf '%0252d' 0).exr
  expect 1 render builtin:cube_g0 --size 16x16 --spp 1 -q -o "$long"
  one_line 'File name too long'
  # The state would have a longer name than its image, which is told before and not after the work.
  expect 1 render builtin:cube_g0 --size 16x16 --spp 1 -q --resume -o "$(printf '%0250d' 0).exr"
  one_line 'File name too long'
}

test_places() {
  mkdir folder.exr
  mkfifo fifo.exr
  for output in folder.exr fifo.exr missing/out.exr plain.exr/out.exr ./; do
    usage_error '(is there already and is not a file|No such file|is not a folder|is a folder|extension)' \
      render builtin:cube_g0 --size 16x16 --spp 1 -o "$output"
  done
  for output in /dev/null /dev/full /proc/self/fd/1; do # stdout is a file here
    usage_error 'extension' render builtin:cube_g0 --size 16x16 --spp 1 -o $output
    usage_error 'is not a file|cannot be written to' convert a.nrrd $output
    usage_error 'is not a file|cannot be written to' render builtin:cube_g0 --size 16x16 --spp 1 -o out.exr --stats $output
  done
  if [ "$(id -u)" -ne 0 ]; then
    mkdir -m 555 locked
    usage_error 'cannot be written to' render builtin:cube_g0 --size 16x16 --spp 1 -o locked/out.exr
    rmdir locked
  fi
  # The link is replaced by the image, and what it named stays.
  cp plain.exr target.exr
  ln -s target.exr link.exr
  expect 0 render builtin:cube_g0 --size 8x8 --spp 1 -o link.exr -q
  cmp -s plain.exr target.exr || fail "the target of the link changed"
  checks=$((checks + 2))
  [ ! -L link.exr ] || fail "link.exr is still a link"
  ln -sf nowhere/at/all dangling.exr
  small -o dangling.exr
  expect 0 info dangling.exr
}

# An output may be an input: it is read whole before it is replaced.
test_outputs_that_are_inputs() {
  cp a.nrrd b.nrrd
  expect 0 convert a.nrrd a.nrrd
  expect 0 convert a.nrrd a.nrrd --codec none
  cmp -s a.nrrd b.nrrd || fail "the volume changed"
  expect 0 render builtin:cube_g0 --size 16x16 --spp 1 --seed 1 --aov depth,variance -o one.exr -q
  expect 0 render builtin:cube_g0 --size 16x16 --spp 1 --seed 2 --aov depth,variance -o two.exr -q
  expect 0 merge one.exr two.exr -o merged.exr
  cp one.exr kept.exr
  expect 0 merge one.exr two.exr -o one.exr
  same merged.exr one.exr
  expect 0 screen kept.exr --medium fog:5 -o screened.exr -q
  expect 0 screen kept.exr --medium fog:5 -o kept.exr -q
  same screened.exr kept.exr
  expect 0 convert two.exr two.png
  expect 0 diff two.png two.png --png two.png
  expect 0 info two.png
  expect 0 convert two.exr two.exr
}

test_limits() {
  for count in 8 16; do
    limited 0 '' "-n $count" render builtin:cornell_fog --size 16x16 --spp 1 -o few.exr --png few.png --resume \
      --stats few.json -q
  done
  limited 1 'cannot write|disk is full' '-f 2' render builtin:cornell_fog --size 64x64 --spp 1 -o large.exr -q
  limited 1 'cannot write|cannot be printed' '-f 2' convert noise.raw large.nrrd --raw-size 16,16,16 --codec none
  absent large.exr
  absent large.nrrd
  # A state that cannot be kept is one warning, also with -q, and the image is made.
  # shellcheck disable=SC2016
  (ulimit -f 40 && exec "$tyndall" render builtin:cornell_fog --size 64x48 --spp 60 -o image.exr --resume \
    --checkpoint 0.05 -q > out.txt 2> err.txt < /dev/null)
  status=$?
  what="ulimit -f 40; tyndall render --resume"
  checks=$((checks + 2))
  [ "$status" -eq 0 ] || fail "exit status $status"
  [ "$(grep -c 'warning: cannot write image.exr.state' err.txt)" -eq 1 ] || fail "not one warning: $(cat err.txt)"
  present image.exr
  absent image.exr.state.lock
  no_temporary_files
}

# Programs with sanitizers need more addresses than there are.
test_memory() {
  (ulimit -v 2000000 && "$tyndall" --version > /dev/null 2>&1) || return 0
  limited 1 'not enough memory' '-v 2000000' render builtin:cube_g0 --size 16000x16000 --spp 1 -o large.exr -q
  limited 1 'not enough memory' '-v 2000000' render builtin:cube_g0 --size 16000x16000 --spp 1 -o large.exr -q --resume
  for size in 300000 250000; do # thousand bytes: too little for ray tracing or for images
    # shellcheck disable=SC2016
    (ulimit -v $size && exec "$tyndall" render builtin:cornell_fog --size 2000x2000 --spp 1 -o large.exr -q \
      > out.txt 2> err.txt < /dev/null)
    status=$?
    what="ulimit -v $size; tyndall render"
    checks=$((checks + 1))
    [ $status -eq 1 ] || fail "exit status $status: $(cat err.txt)"
    one_line .
  done
  absent large.exr
  # Threads whose stacks do not fit are done without, or there is one line; 600 MB is where TBB's arena does not fit.
  expect 0 render builtin:cornell_fog --size 16x16 --spp 1 -o few.exr -q
  for size in 250000 400000 560000 600000 640000 2000000; do
    # shellcheck disable=SC2016
    (ulimit -v $size && exec timeout 60 "$tyndall" render builtin:cornell_fog --size 16x16 --spp 1 -o threads.exr \
      --threads 512 -q > out.txt 2> err.txt < /dev/null)
    status=$?
    what="ulimit -v $size; tyndall render --threads 512"
    checks=$((checks + 1))
    case $status in
    0) same few.exr threads.exr ;;
    1) one_line . ;;
    *) fail "exit status $status: $(cat err.txt)" ;;
    esac
  done
  # Files that end in 5 GB of nothing, each after a beginning that its reader knows: refused before they are read.
  expect 0 convert noise.raw ok.nvdb --raw-size 16,16,16
  expect 0 convert noise.raw ok.vdb --raw-size 16,16,16
  expect 0 convert noise.raw packed.nrrd --raw-size 16,16,16
  expect 0 convert plain.exr ok.png
  cp plain.exr huge.exr
  cp ok.png huge.png
  printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n' > huge.hdr
  printf '\xff\xd8\xff\xe0' > huge.jpg
  printf 'RIFF\x20\0\0\0WEBPVP8 ' > huge.webp
  printf '{"asset": {"version": "2.0"}}' > huge.gltf
  printf 'glTF\2\0\0\0\x40\0\0\0\x10\0\0\0JSON{' > huge.glb
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > huge.obj
  elements='element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n'
  list='property list uchar int vertex_indices\nend_header\n'
  printf "ply\nformat ascii 1.0\n$elements${list}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" > huge.ply
  printf "ply\nformat binary_little_endian 1.0\n$elements$list" > binary.ply
  cp a.nrrd huge.nrrd
  { head -c 128 /dev/zero; printf 'DICM\340\177\20\0OB\0\0\4\0\0\0abcd'; } > huge.dcm
  printf 'VOL\3\3\0\0\0\1\0\0\0\1\0\0\0\1\0\0\0\1\0\0\0' > huge.vol
  truncate -s 49 huge.vol
  printf '<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 1 0 1"><Piece Extent="0 1 0 1 0 1"><PointData>
    <DataArray type="UInt8" Name="v" format="appended" offset="0"/></PointData></Piece></ImageData>
    <AppendedData encoding="raw">_' > huge.vti
  printf '# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nPOINT_DATA 8\nVECTORS v int\n' > huge.vtk
  cp ok.nvdb huge.nvdb
  printf '{"tyndall": 1}' > huge.json
  : > huge.bin
  printf '{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"huge.bin"}],"nodes":[{"mesh":0}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}' > buffer.gltf
  truncate -s 5G huge.* binary.ply packed.nrrd
  for file in huge.{exr,png,hdr,jpg,webp,glb,vti,vtk} binary.ply packed.nrrd; do
    limited 2 "$file: 5368709120 bytes, of which its header accounts for" '-v 1000000' info $file
  done
  for file in huge.{gltf,obj,ply}; do
    limited 2 "$file: byte [0-9]+ is a zero, which no text has" '-v 1000000' info $file
  done
  limited 2 'huge.bin: 5368709120 bytes, more than the limit' '-v 1000000' info buffer.gltf
  limited 2 'huge.dcm: 5368709120 bytes, more than the limit|without pixel data|colour|0 x 0' '-v 1000000' info huge.dcm
  limited 2 'huge.vol: 5368709120 bytes, of which its header accounts for 49' '-v 1000000' info huge.vol
  limited 2 'huge.nrrd: more than 16384 bytes for 16 x 16 x 16 voxels' '-v 1000000' info huge.nrrd
  limited 2 'huge.nvdb: ' '-v 1000000' info huge.nvdb
  limited 2 'huge.json: 5368709120 bytes, more than the limit' '-v 1000000' info huge.json
  rm huge.* binary.ply packed.nrrd
  cp ok.vdb huge.vdb # which is read in parts, by its own directory
  truncate -s 5G huge.vdb
  limited 0 '' '-v 2000000' info huge.vdb
  truncate -s 5G huge.raw
  limited 2 'voxels' '-v 2000000' info huge.raw --raw-size 1024,1024,5119
  # Of a raw file only the samples are kept: here the last ones. Its bytes all count for the scene's hash, so that it is no
  # larger than this takes.
  truncate -s 700M huge.raw
  printf '{"tyndall": 1, "media": [{"bounds": [[0, 0, 0], [1, 1, 1]], "sigma_s": 1, "sigma_a": 0,
    "density": {"file": "huge.raw", "raw": {"size": [16, 16, 16], "offset": -1}}}]}' > tail.json
  limited 0 '' '-v 600000' info tail.json
  rm huge.*
}

test_numbers() {
  usage_error 'is not a size' render builtin:cube_g0 --size 70000x70000 -o large.exr
  usage_error 'from 1 to 16777216' render builtin:cube_g0 --spp 2147483648 -o large.exr
  usage_error 'outside .1, 16777216.' render builtin:cube_g0 -D render.spp=2147483648 -o large.exr
  usage_error 'from 0 to 1024' render builtin:cube_g0 --threads 100000 -o large.exr
  expect 1 render builtin:cube_g0 --size 65536x65536 --spp 1 -o large.exr -q
  one_line 'not enough memory'
  small -o threads.exr --threads 512
  same plain.exr threads.exr
}

test_large_scenes() {
  awk 'BEGIN {
    printf "{\"tyndall\": 1, \"camera\": {\"position\": [0, 1, 5], \"target\": [0, 0, 0]}, \"lights\": [\n"
    for (i = 0; i < 100000; ++i)
      printf "%s{\"type\": \"point\", \"position\": [%d, %d, %d], \"intensity\": 1}\n", i ? "," : "", i % 100, i / 100 % 100,
        i / 10000
    printf "], \"geometry\": [{\"sphere\": {\"center\": [0, 0, 0], \"radius\": 1}, \"material\": {\"albedo\": 0.8}}]}\n" }' \
    > lights.json
  expect 0 render lights.json --size 16x16 --spp 1 -o lights.exr -q --method path
  awk 'BEGIN {
    printf "{\"tyndall\": 1, \"media\": [\n"
    for (i = 0; i < 10000; ++i)
      printf "%s{\"bounds\": [[%d, 0, 0], [%d.5, 1, 1]], \"sigma_s\": 1, \"sigma_a\": 0}\n", i ? "," : "", i, i
    printf "]}\n" }' > media.json
  usage_error 'media.json:66: media\[64\]: .*more than 64' render media.json -o media.exr
  for deep in '[' '{"a":'; do
    { printf '{"tyndall": 1, "media":'; yes "$deep" | head -n 100000 | tr -d '\n'; } > deep.json
    usage_error 'deep.json:1: .*depth' render deep.json -o deep.exr
  done
  { printf '{"asset": {"version": "2.0"}, "extras":'; yes '[' | head -n 100000 | tr -d '\n'; } > deep.gltf
  usage_error 'deep.gltf:1: .*depth' info deep.gltf
  # 50 MB of JSON in one text.
  { printf '{"tyndall": 1, "camera": {"name": "'; head -c 50000000 /dev/zero | tr '\0' x; printf '"}}'; } > text.json
  usage_error 'text.json:1: camera.name' render text.json -o text.exr
  rm -f ./*.json
}

head -c 4096 /dev/urandom > noise.raw
expect 0 convert noise.raw a.nrrd --raw-size 16,16,16 --codec none
test_names
test_places
test_outputs_that_are_inputs
test_limits
test_memory
test_numbers
test_large_scenes
finish 150
