#!/usr/bin/env bash
# Runs every fuzz target for FUZZ_SECONDS (600 unless set). What a target learns goes to build/fuzz/corpus; an input
# that breaks it goes to build/fuzz/found, and the script then fails.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${FUZZ_SECONDS:-600}

scripts/build.sh fuzz
mkdir -p build/fuzz/found
failed=()
for program in build/fuzz/bin/fuzz_*; do
  name=$(basename "$program")
  learnt=build/fuzz/corpus/${name#fuzz_}
  mkdir -p "$learnt"
  folders=("$learnt")
  seeds=tests/fuzz/corpus/${name#fuzz_}
  [ ! -d "$seeds" ] || folders+=("$seeds")
  echo "fuzz: $name for $seconds s"
  LSAN_OPTIONS=suppressions=cmake/lsan.txt:print_suppressions=0 "$program" "${folders[@]}" \
    -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/found/$name-" > "build/fuzz/$name.log" 2>&1 || failed+=("$name")
  grep -E 'stat::(number_of_executed_units|new_units_added)' "build/fuzz/$name.log" || true
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "fuzz: broken: ${failed[*]} (logs in build/fuzz, inputs in build/fuzz/found)" >&2
  exit 1
fi
echo "fuzz: nothing found"
