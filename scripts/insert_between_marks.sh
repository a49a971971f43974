#!/usr/bin/env bash
# Puts a file between the marks of a page: insert_between_marks.sh PAGE.md NAME FILE. The marks are the lines
# <!-- NAME --> and <!-- end of NAME -->; what was between them goes.
set -euo pipefail
page=$1 name=$2 file=$3
for mark in "<!-- $name -->" "<!-- end of $name -->"; do
  [ "$(grep -cFx -- "$mark" "$page")" -eq 1 ] || { echo "$page: must have one line '$mark'" >&2; exit 1; }
done
awk -v begin="<!-- $name -->" -v end="<!-- end of $name -->" -v file="$file" '
  $0 == end { inside = 0 }
  !inside { print }
  $0 == begin { inside = 1; print ""; while ((getline line < file) > 0) print line; print "" }
' "$page" > "$page.tmp"
mv "$page.tmp" "$page"
