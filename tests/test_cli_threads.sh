#!/usr/bin/env bash
# Commands where no thread can be started: those that have no use for one do not ask, and all others do their work in the
# first thread, with the same result.
# usage: test_cli_threads.sh TYNDALL NO_THREADS (works in the current folder, which it empties)
. "$(dirname "$0")/cli.sh"
no_threads=$2

# alone COMMAND...: runs it without threads, as expect does; how many were wanted is in `threads`.
alone() {
  LD_PRELOAD=$no_threads expect 0 "$@"
  threads=$(grep -c '^a thread is wanted$' err.txt)
}
small=(builtin:demo --spp 2 --size 48x32 -q --threads 4)
expect 0 render "${small[@]}" -o with.exr
head -c 4096 "$tyndall" > bytes.raw
expect 0 convert -q bytes.raw --raw-size 16,16,16 bytes.vdb
expect 0 convert -q bytes.vdb with.nrrd

for command in help --version "info with.exr" "info bytes.vdb" "diff with.exr with.exr"; do
  # shellcheck disable=SC2086
  alone $command
  [ "$threads" -eq 0 ] || fail "it wants $threads threads"
done
alone info builtin:cube_g0
alone convert -q bytes.vdb without.nrrd
cmp with.nrrd without.nrrd || fail "another volume without threads"
alone render "${small[@]}" -o without.exr
[ "$threads" -gt 0 ] || fail "the preloaded library is not in use"
same with.exr without.exr
alone render builtin:cornell_fog --size 48x32 -q --threads 4 --method fld -o fld.exr
present fld.exr

# OpenVDB's library would start threads before main, through log4cplus.
if command -v readelf > /dev/null; then
  readelf -d "$tyndall" > needed.txt
  said needed.txt 'NEEDED'
  unsaid needed.txt 'NEEDED.*(openvdb|log4cplus)'
fi
finish 17
