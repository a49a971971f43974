#!/usr/bin/env bash
# The shared library exports the functions that the headers declare and nothing else, as cmake/symbols.txt lists them,
# under the soname of its version; it needs no library that starts threads of its own.
# usage: test_symbols.sh LIBRARY SOURCE_FOLDER [--update] (works in the current folder)
set -euo pipefail
export LC_ALL=C
library=$1
source=$2
command -v nm > /dev/null || { echo "test_symbols: nm is not here, nothing was compared"; exit 1; }

nm -D --defined-only "$library" | awk '{print $NF}' | sort > exported.txt
cat "$source"/include/tyndall/*.h | tr '\n' ' ' | grep -oE 'TY_API [A-Za-z0-9_ *]+\(' | sed -nE 's/.*[ *](ty_[a-z0-9_]+)\($/\1/p' |
  sort -u > declared.txt
if [ "${3:-}" = --update ]; then
  cp exported.txt "$source/cmake/symbols.txt"
fi
[ "$(wc -l < exported.txt)" -gt 100 ] || { echo "only $(wc -l < exported.txt) symbols were found"; exit 1; }
diff -u declared.txt exported.txt || { echo "the library does not export what the headers declare"; exit 1; }
diff -u "$source/cmake/symbols.txt" exported.txt || {
  echo "the exported symbols have changed; if they should: tests/test_symbols.sh LIBRARY SOURCE_FOLDER --update"
  exit 1
}
version=$(sed -n 's/^#define TY_VERSION "\([0-9]*\.[0-9]*\)\..*/\1/p' "$source/include/tyndall/base.h")
objdump -p "$library" > headers.txt
grep -q "SONAME *libtyndall\.so\.$version\$" headers.txt || { grep SONAME headers.txt; exit 1; }
! grep -E 'NEEDED.*(openvdb|log4cplus)' headers.txt || exit 1
echo "$(wc -l < exported.txt) symbols"
