#!/bin/bash
# Prints an image in parts as a file for OpenCue's cuecmd, one command a line, and the command that merges them:
#   opencue_parts.sh /shared/scene.json /shared/out.exr 64 > parts.txt && cuecmd parts.txt
# usage: opencue_parts.sh SCENE OUT.exr PARTS [options of tyndall render]
set -eu
scene=$1 out=$2 parts=$3
shift 3
base=${out%.exr}
for part in $(seq "$parts"); do
  printf 'tyndall render'
  printf ' %q' "$scene" "$@" --part "$part/$parts" --resume -o "$base.part$part.exr"
  printf '\n'
done
echo "when all have ended: tyndall merge $(printf '%q' "$base").part*.exr -o $(printf '%q' "$out")" >&2
