#!/usr/bin/env bash
# The house's rules that can be counted (docs/architecture.md): what each room may include, which library only one file
# sees, how long files may get, and that the page's table of rooms is true.
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

# room: the rooms below it. What a room has of its own is always allowed. Rooms of tools/ are its folders.
library="base comm device option grid scene direct image solve method bake choose io"
declare -A below=(
  [base]=""
  [comm]="base"
  [device]="base"
  [option]="base"
  [grid]="base"
  [scene]="base device option grid"
  [direct]="base comm option grid scene"
  [image]="base device option grid scene direct"
  [solve]="base comm device option grid scene direct"
  [method]="base comm device option grid scene direct image solve method/diffuse method/gradient"
  [bake]="base comm device option grid scene direct image solve method/impulse method/path"
  [io]="base option grid scene image"
  [cli]="$library"
  [plot]="base"
  [scenes]="io"
  [bench]="$library cli scenes"
  [figures]="$library cli scenes bench plot"
)

# The same within direct, pop and dom, whose parts depend on one another in one direction alone. airlight, which has its own
# single scattering, is left out.
declare -A parts_below=(
  [direct/media]=""
  [direct/shadow]="direct/media"
  [direct/lights]="direct/media direct/shadow"
  [direct/single]="direct/media direct/lights"
  [direct/uncollided]="direct/media direct/lights direct/single"
  [direct/surfaces]="direct/media direct/shadow direct/lights direct/single"
  [method/pop/ordinate]=""
  [method/pop/grid]=""
  [method/pop/merge]="method/pop/grid"
  [method/pop/published]="method/pop/grid method/pop/merge"
  [method/dom/solve]=""
  [method/dom/sources]="method/dom/solve"
  [method/dom/view]="method/dom/sources"
)
for part in "${!parts_below[@]}"; do
  room=${part%/*}
  while IFS=: read -r file include; do
    case "$file" in */airlight*) continue ;; esac
    target=${include#*\"}
    target=${target%/*}
    case " $room $part ${parts_below[$part]} " in
      *" $target "*) ;;
      *) complain "$file: $include: $part may include ${parts_below[$part]:-nothing} of $room alone" ;;
    esac
  done < <(grep -HoE "^#include \"$room/[^\"]+\"" $(sources "src/$part"))
done

count=0
for room in "${!below[@]}"; do
  while IFS=: read -r file include; do
    count=$((count + 1))
    target=${include#*\"}
    target=${target%/*}
    own=${file#src/}
    own=${own#tools/}
    rest=${own#method/}
    if [ "$rest" != "$own" ]; then own=method/${rest%%/*}; else own=${own%%/*}; fi
    allowed=no
    for name in "$own" ${below[$room]}; do
      case "$target" in "$name" | "$name"/*) allowed=yes ;; esac
    done
    # The registry and what all methods share lie in method itself.
    [ "$room:$target" != method:method ] || allowed=yes
    # Tables that are kept between runs.
    [ "$file:$include" != 'src/method/impulse/file.c:#include "io/file.h"' ] || allowed=yes
    [ $allowed = yes ] || complain "$file: $include: $room may include ${below[$room]:-nothing} alone"
  done < <(grep -HoE '^#include "[^"]+/[^"]+"' $(sources $(ls -d "src/$room" "tools/$room" 2> /dev/null)))
done
[ $count -gt 500 ] || complain "only $count includes were found"

# No circle of rooms: an arrow goes from each folder to the folders that its files include. A folder with sub-rooms has
# its headers below them and its .c files, which nothing includes, above them.
parents=" $(sources src tools | sed -E 's,^(src|tools)/,,; s,/[^/]*$,,' | sort -u | sed -nE 's,/[^/]*$,,p' | sort -u | tr '\n' ' ')"
circles=$(grep -HoE '^#include "[^"]+/[^"]+"' $(sources src tools) | awk -F'[:"]' -v parents="$parents" '
  { file = $1; sub(/^(src|tools)\//, "", file)
    from = file; sub(/\/[^\/]*$/, "", from)
    to = $3; sub(/\/[^\/]*$/, "", to)
    if (file ~ /[.]c(pp)?$/ && index(parents, " " from " ") > 0) from = from "/*.c"
    if (from != to) print from, to
  }' | sort -u | tsort 2>&1 > /dev/null) || true
[ -z "$circles" ] || complain "rooms include one another in a circle:" $(sed -n 's/^tsort: //p' <<< "$circles" | grep -v 'contains a loop')

# pattern of headers: the files that may see them
only() {
  local file
  for file in $(grep -lE "^ *#include <$1" $(sources src tools)); do
    case " $2 " in *" $file "*) ;; *) complain "$file sees <$1...>, which is for $2" ;; esac
  done
}
only embree "src/scene/surfaces/accel.c tools/bench/embree.c"
only cairo "tools/plot/canvas.c"
only civetweb "src/cli/view/server.c tools/bench/view_client.c"
only turbojpeg "src/cli/view/frame.c"
only blosc "src/io/volumes/vdb_tree.c src/io/volumes/vdb_write.c"
only tiffio "src/io/volumes/tiff.c"
only gdcmjpeg "src/io/volumes/dicom/jpeg8.c src/io/volumes/dicom/jpeg12.c src/io/volumes/dicom/jpeg16.c"
only charls "src/io/volumes/dicom/jpeg_ls.c"
only openjpeg "src/io/volumes/dicom/jpeg_2000.c"
only expat "src/io/volumes/vtk/vti_header.c src/io/interchange/mitsuba/tree.c"
only mpi.h "src/comm/mpi.c"
only netcdf "src/io/volumes/netcdf/calls.h"
only openvdb "no file: it starts threads before main"

while read -r lines file; do
  [ "$lines" -le 800 ] || complain "$file has $lines lines; split it (800 at most)"
done < <(wc -l $(sources src tools include tests examples) | grep -v ' total$')

# What a test wrote when it was run here by hand is not committed by accident.
for file in $(find . -maxdepth 1 -type f -printf '%f\n' | tr ' ' '_'); do
  case $file in
  CHANGELOG.md | CITATION.cff | CMakeLists.txt | CMakePresets.json | CONTRIBUTING.md | LICENSE | Makefile | README.md | SECURITY.md | .*) ;;
  *) complain "$file is not a file of the project's folder" ;;
  esac
done

# The page's table of rooms, in both directions: each folder with source files has a row, each row is such a folder.
# Files that the page names exist. A comment in the first line of each file, or of its
# header, tells its contents.
page=docs/architecture.md
rooms=$(sed -n -E 's/^\| ([a-z][a-z/]*) \| .*/\1/p' $page | grep -v '^room$')
for room in $rooms; do
  folder=src/$room
  case $room in tools/*) folder=$room ;; esac
  [ -n "$(sources "$folder" 2> /dev/null)" ] || complain "$page: $room: there is no such folder with source files"
done
for folder in $(sources src tools | sed 's,/[^/]*$,,' | sort -u); do
  case $'\n'$rooms$'\n' in *$'\n'"${folder#src/}"$'\n'*) ;; *) complain "$page: no row for $folder" ;; esac
done
files=$(find . \( -path ./build -o -path ./.git \) -prune -o -type f -print)$'\n'
for name in $(grep -oE '`[A-Za-z0-9_./]+\.(c|h|cpp|sh|cmake|json)`' $page | tr -d '`' | grep -vE 'NAME|ROOM|room/file' | sort -u); do
  case $files in *"/$name"$'\n'*) ;; *) complain "$page: there is no $name" ;; esac
done
for file in $(sources src tools | xargs awk '
  FNR == 1 { if ($0 ~ /^(\/\*|\/\/)/) commented[FILENAME] = 1; else bare[FILENAME] = 1; nextfile }
  END { for (file in bare) { header = file; sub(/[.]c$/, ".h", header); if (!(header in commented)) print file } }'); do
  complain "$file: neither it nor its header begins with a comment"
done

# Under pipefail a search that ends at its first match breaks the pipe of whatever writes into it: the output is read as a
# whole first.
while IFS= read -r line; do
  complain "$line: a pipe into grep -q"
done < <(grep -nE '[|] *grep +-[A-Za-z]*q' tests/*.sh tests/*/*.sh scripts/*.sh)

[ $failed = 0 ] || exit 1
echo "architecture: $count includes point down"
