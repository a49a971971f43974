#!/usr/bin/env bash
# Where numbers are written with a comma, files and reports stay as they are.
# usage: test_cli_locale.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

# A locale with a decimal comma, installed or made here; none: empty.
comma_locale() {
  for name in $(locale -a 2> /dev/null); do
    [ "$(LC_ALL=$name locale decimal_point 2> /dev/null)" = , ] && echo "$name" && return
  done
  mkdir -p locales
  localedef -i de_DE -f UTF-8 ./locales/de_DE.UTF-8 > /dev/null 2>&1 || return
  [ "$(LOCPATH=$PWD/locales LC_ALL=de_DE.UTF-8 locale decimal_point 2> /dev/null)" = , ] && echo de_DE.UTF-8
}

# Everything that reads or writes decimals, into the folder $1.
work() {
  mkdir "$1"
  expect 0 render scene.json -o "$1/a.exr" --size 8x8 --spp 2 --error 0.5 -q -D 'media[0].g=0.25' --exposure 0.5
  expect 0 info scene.json
  cp out.txt "$1/scene.txt"
  expect 0 info scene.json --json
  cp out.txt "$1/scene_json.txt"
  expect 0 convert letters.raw "$1/a.nrrd" --raw-size 2,3,4 --raw-spacing 0.5,1.25,2 --codec none
  expect 0 convert "$1/a.nrrd" "$1/a.vdb"
  expect 0 convert "$1/a.vdb" "$1/b.nrrd" --codec none
  expect 0 info "$1/a.nrrd" --json
  grep -v '"file"' out.txt > "$1/volume.txt"
  expect 0 info shape.obj --json
  cp out.txt "$1/mesh.txt"
  expect 0 diff "$1/a.exr" plain.exr --json
  cp out.txt "$1/diff.txt"
}

printf 'abcdefghijklmnopqrstuvwx' > letters.raw
printf 'v 0 0 0\nv 1.5 0 0\nv 0 1.25 0\nf 1 2 3\n' > shape.obj
printf '{"tyndall": 1, "media": [{"sigma_t": 1.5, "albedo": 0.5, "bounds": [[0, 0, 0], [1.5, 1, 1]]}],
 "lights": [{"type": "environment", "radiance": 0.25}], "geometry": [{"file": "shape.obj"}]}' > scene.json
expect 0 render scene.json -o plain.exr --size 8x8 --spp 1 -q
name=$(comma_locale)
if [ -z "$name" ]; then
  echo "skipped: no locale with a decimal comma is installed, and none can be made"
  exit 0
fi
work plain
{
  echo '#!/bin/sh'
  [ ! -d "locales/$name" ] || echo "export LOCPATH='$PWD/locales'"
  echo "LC_ALL='$name' exec '$tyndall' \"\$@\""
} > with_comma
chmod +x with_comma
tyndall=./with_comma
work comma
for file in a.nrrd b.nrrd scene.txt scene_json.txt volume.txt mesh.txt diff.txt; do
  what="$file with LC_ALL=$name"
  checks=$((checks + 1))
  cmp -s "plain/$file" "comma/$file" || fail "it differs: $(diff "plain/$file" "comma/$file" | head -n 4)"
done
expect 0 diff plain/a.exr comma/a.exr
said out.txt '^values that differ: 0$'
finish 25
