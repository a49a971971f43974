#!/usr/bin/env bash
# Every public symbol has a documentation comment: Doxygen finds none without one, and reports a new one.
# usage: test_api_docs.sh SOURCE_FOLDER (works in the current folder, which it empties)
set -euo pipefail
source=$1
. "$(dirname "$0")/scratch.sh"
if ! command -v doxygen > /dev/null; then
  echo "skipped: there is no doxygen (scripts/setup.sh docs)"
  exit 0
fi
mkdir docs
cp -r "$source/include" "$source/scripts" .
cp -r "$source/docs/api" docs/api

scripts/docs.sh api > log.txt 2>&1 || { cat log.txt; exit 1; }
grep -q 'ty_path_render' api/path_8h.html || { echo "the reference lacks ty_path_render"; exit 1; }

# without HEADER LINE: the reference is refused when a header has another line with a symbol without a comment.
without() {
  cp "include/tyndall/$1" kept.h
  sed -i "s/^\(typedef struct ty_scene ty_scene;\|#ifndef TYNDALL_BASE_H\)\$/\1\n\n$2\n/" "include/tyndall/$1"
  if cmp -s kept.h "include/tyndall/$1"; then echo "nothing was changed in $1"; exit 1; fi
  if scripts/docs.sh api > log.txt 2>&1; then echo "$2 went unnoticed"; exit 1; fi
  grep -q 'not documented' log.txt || { cat log.txt; exit 1; }
  cp kept.h "include/tyndall/$1"
}
without scene.h 'TY_API void ty_scene_wordless(ty_scene* scene);'
without scene.h '\/\/\/ One.\ntypedef struct ty_wordless {\n    int a;\n    int b; \/\/\/< Two.\n} ty_wordless;'
without base.h '#define TY_WORDLESS 1'
echo "all public symbols have words"
