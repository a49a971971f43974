#!/usr/bin/env bash
# The house's rules that can be counted (docs/architecture.md): what each room may include, which library only one file
# sees, how long files may get, and that the page names every file.
# usage: test_architecture.sh SOURCE_DIR
set -euo pipefail
cd "$1"
failed=0

complain() {
  echo "architecture: $*" >&2
  failed=1
}

sources() {
  find "$@" -name '*.[ch]' -o -name '*.cpp'
}

# room: the rooms below it. What a room has of its own is always allowed.
declare -A below=(
  [base]=""
  [grid]="base"
  [scene]="base grid"
  [direct]="base grid scene"
  [image]="base grid scene direct"
  [solve]="base grid scene direct"
  [method]="base grid scene direct image solve"
  [bake]="base grid scene direct image solve method/impulse method/path"
  [io]="base grid scene image"
  [plot]="base"
)

count=0
for room in "${!below[@]}"; do
  while IFS=: read -r file include; do
    count=$((count + 1))
    target=${include#*\"}
    target=${target%/*}
    own=${file#src/}
    rest=${own#method/}
    if [ "$rest" != "$own" ]; then own=method/${rest%%/*}; else own=${own%%/*}; fi
    allowed=no
    for name in "$own" ${below[$room]}; do
      case "$target" in "$name" | "$name"/*) allowed=yes ;; esac
    done
    # Tables that are kept between runs.
    [ "$file:$include" != 'src/method/impulse/file.c:#include "io/file.h"' ] || allowed=yes
    [ $allowed = yes ] || complain "$file: $include: $room may include ${below[$room]:-nothing} alone"
  done < <(grep -HoE '^#include "[^"]+/[^"]+"' $(sources "src/$room"))
done
[ $count -gt 500 ] || complain "only $count includes were found"

# pattern of headers: the files that may see them
only() {
  local file
  for file in $(grep -lE "^ *#include <$1" $(sources src)); do
    case " $2 " in *" $file "*) ;; *) complain "$file sees <$1...>, which is for $2" ;; esac
  done
}
only embree "src/scene/accel.c src/cli/bench/embree.c"
only cairo "src/plot/canvas.c"
only openvdb "src/io/volumes/vdb.cpp"

while read -r lines file; do
  [ "$lines" -le 800 ] || complain "$file has $lines lines; split it (800 at most)"
done < <(wc -l $(sources src include tests examples) | grep -v ' total$')

# Files of the rooms that have a line in the page's table, but for those that many rooms have: job.h, what is named for
# the room, and the choice of an instruction set.
page=docs/architecture.md
while IFS='|' read -r _ room text _; do
  room=${room// /}
  [ -d "src/$room" ] || continue
  for file in src/"$room"/*.[ch] src/"$room"/*.cpp; do
    [ -f "$file" ] || continue
    name=${file##*/}
    stem=${name%%.*}
    case "$room/$stem" in cli/* | io/* | */job | */*kernels | */"${room##*/}") continue ;; esac
    [[ $text =~ [\`\ ]$stem(\.k\.h|\.h|\.c)?[\`,\;:\ \)] ]] || complain "$page: $room: nothing about $name"
  done
done < <(grep -E '^\| [a-z/]+ \|' $page)

[ $failed = 0 ] || exit 1
echo "architecture: $count includes point down"
