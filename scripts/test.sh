#!/usr/bin/env bash
# Builds and runs all quick tests: unit, cli and truth optimised, then unit again under the address and undefined
# behaviour sanitizers. One ctest run over both builds, so that its closing line counts everything.
set -euo pipefail
cd "$(dirname "$0")/.."

for preset in release asan; do
  scripts/build.sh "$preset"
done
mkdir -p build/all
printf 'subdirs("%s" "%s")\n' "$PWD/build/release" "$PWD/build/asan" > build/all/CTestTestfile.cmake
# Four more tests than processors: several wait for a server, a browser or a disk (CTest begins with these, by COST).
ctest --test-dir build/all --output-on-failure -j "$(($(nproc) + 4))"
