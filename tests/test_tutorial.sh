#!/usr/bin/env bash
# Runs the commands of docs/tutorial.md as they stand there, and looks for the files that they promise.
# usage: test_tutorial.sh TYNDALL SOURCE_FOLDER (works in the current folder, which it empties)
set -euo pipefail
rm -rf ./*
mkdir -p build/release
ln -s "$(dirname "$1")" build/release/bin
ln -s "$2/examples" examples
awk '/^```sh$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$2/docs/tutorial.md" | grep -v '^make$' > commands.sh
[ "$(grep -c '^tyndall ' commands.sh)" -ge 20 ] || { echo "the tutorial has fewer commands than it should"; exit 1; }
bash -euo pipefail commands.sh > log.txt 2>&1 || { cat log.txt; exit 1; }
cd out/tutorial
for file in cloud.png fast.png report/report.html smoke.vdb smoke.png soot.png level.png baked/walls.exr baked/room.glb \
  baked/ball.exr probes/grid.exr photo.png depth.png foggy.png sea.png milk.png; do
  [ -s "$file" ] || { echo "the tutorial left no $file"; exit 1; }
done
echo "all commands of the tutorial do what it says"
