#!/usr/bin/env bash
# Makes the reference of the C API (docs/api/Doxyfile) and fails where a public symbol has no words.
# usage: scripts/docs.sh [FOLDER]   (default: build/docs/api)
set -euo pipefail
folder=$(realpath -m "${1:-$(dirname "$0")/../build/docs/api}")
cd "$(dirname "$0")/.."
mkdir -p "$folder"
version=$(sed -n 's/^#define TY_VERSION "\(.*\)"/\1/p' include/tyndall/base.h)
{
  cat docs/api/Doxyfile
  printf 'OUTPUT_DIRECTORY = "%s"\nPROJECT_NUMBER = %s\n' "$folder" "$version"
} | doxygen -
