#!/bin/bash
# An image in parts by machines that share a folder, with nothing but a shell: start it on each, at any time. A machine
# takes the next part that nobody has; the last one merges.
# usage: shell_parts.sh SCENE OUT.exr PARTS [options of tyndall render]
set -eu
scene=$1 out=$2 parts=$3
shift 3
base=${out%.exr}
for part in $(seq "$parts"); do
  [ ! -e "$base.part$part.exr" ] || continue
  mkdir "$base.part$part.taken" 2> /dev/null || continue # remove the folder of a machine that died
  tyndall render "$scene" "$@" --part "$part/$parts" --resume -o "$base.part$part.exr"
  rmdir "$base.part$part.taken"
done
for part in $(seq "$parts"); do [ -e "$base.part$part.exr" ] || exit 0; done
[ "$parts" -gt 1 ] || exit 0
mkdir "$base.merge.taken" 2> /dev/null || exit 0
tyndall merge "$base".part*.exr -o "$out"
rmdir "$base.merge.taken"
