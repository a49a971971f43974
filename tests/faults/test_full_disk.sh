#!/usr/bin/env bash
# Writers on a disk that is full: a tmpfs of a few pages in a mount namespace of its own, and /dev/full for what is printed.
# usage: test_full_disk.sh TYNDALL (empties the current folder); 77: no disk can be mounted here
if [ "${2:-}" != mounted ]; then
  for how in --map-root-user ""; do
    # shellcheck disable=SC2086 # none or one option
    if unshare --mount $how bash -c 'mount -t tmpfs -o size=200k tmpfs /mnt' 2> /dev/null; then
      # shellcheck disable=SC2086
      exec unshare --mount $how bash "$0" "$1" mounted
    fi
  done
  echo "skipped: mounting a tmpfs is refused here"
  exit 77
fi
. "$(dirname "$0")/../cli.sh"
disk=$PWD/disk
mkdir "$disk"
mount -t tmpfs -o size=200k tmpfs "$disk" || exit 77

# fill BYTES: the disk has so many bytes left.
fill() {
  rm -f "$disk"/filler
  free=$(df --output=avail -B1 "$disk" | tail -n 1)
  [ "$free" -le "$1" ] || head -c $((free - $1)) /dev/zero > "$disk"/filler
}

# full_disk OUTPUT ARGUMENT...: with 0 to some pages left the command fails with one line, and keeps the earlier file.
full_disk() {
  output=$1
  shift
  for free in 0 4096 8192 16384; do
    rm -f "$disk"/*
    echo earlier > "$output"
    fill $free
    expect 1 "$@"
    said err.txt "^tyndall: cannot write .*: No space left on device"
    checks=$((checks + 3))
    [ "$(grep -vcE '^(path|solving|render[a-z]*):' err.txt)" -eq 1 ] || fail "not one line: $(cat err.txt)"
    [ "$(cat "$output")" = earlier ] || fail "the earlier $output is gone"
    [ "$(find "$disk" -type f ! -name filler ! -path "$output" | wc -l)" -eq 0 ] || fail "left: $(ls "$disk")"
  done
}

noisy="builtin:cornell_fog --spp 1 -q"
# shellcheck disable=SC2086
expect 0 render $noisy --size 96x96 -o a.exr --aov depth
# shellcheck disable=SC2086
expect 0 render $noisy --size 96x96 -o b.exr --aov depth --seed 2
head -c 262144 /dev/urandom > in.raw
# shellcheck disable=SC2086
full_disk "$disk/out.exr" render $noisy --size 96x96 -o "$disk/out.exr"
# shellcheck disable=SC2086
full_disk "$disk/out.png" render $noisy --size 160x160 -o "$disk/out.png"
full_disk "$disk/out.exr" merge a.exr b.exr -o "$disk/out.exr"
full_disk "$disk/out.exr" screen a.exr -o "$disk/out.exr" --medium fog:5 -q
for kind in nrrd nvdb vdb; do
  full_disk "$disk/out.$kind" convert in.raw "$disk/out.$kind" --raw-size 64,64,64
done

# With room again the same command succeeds.
rm -f "$disk"/*
expect 0 merge a.exr b.exr -o "$disk/out.exr"
present "$disk/out.exr"

# What is printed, to a device that is always full.
checks=$((checks + 1))
"$tyndall" info a.exr > /dev/full 2> err.txt
status=$?
[ $status -eq 1 ] || fail "info > /dev/full: exit status $status"
said err.txt '^tyndall: the result cannot be printed: No space left on device$'

umount "$disk"
finish 110
