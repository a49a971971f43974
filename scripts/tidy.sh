#!/usr/bin/env bash
# Runs clang-tidy with the checks of .clang-tidy on every source file that the release preset compiles, but for what the
# build writes itself. Prints all findings, and fails if there are any.
# usage: scripts/tidy.sh [PATTERN]   (of file names, such as src/solve; default: all)
set -euo pipefail
cd "$(dirname "$0")/.."
pattern=${1:-.}
mkdir -p build/release
cmake --preset release > build/release/configure.log 2>&1 || { cat build/release/configure.log >&2; exit 1; }
python3 -c '
import json, sys
entries = json.load(open("build/release/compile_commands.json"))
print("\n".join(sorted({e["file"] for e in entries if "/build/release/" not in e["file"]})))' |
  grep -e "$pattern" |
  xargs -P "$(nproc)" -n 8 clang-tidy -p build/release --quiet --extra-arg=-Wno-unknown-warning-option
