#!/usr/bin/env bash
# Signals, closed streams, kills, and two processes at one output. usage: test_cli_signals.sh TYNDALL (empties the current
# folder). With TYNDALL_IN_FULL=1 kills come after 1 to 12 seconds, of several scenes, one of them of 1920 x 1080 pixels.
. "$(dirname "$0")/cli.sh"

scene="builtin:cornell_fog --size 160x120"

# ended STATUS NAME: what was started ends with the status of the signal NAME, which its last line on stderr tells.
ended() {
  finished "$1"
  checks=$((checks + 1))
  [ "$(tail -n 1 err.txt)" = "tyndall: interrupted by $2" ] || fail "the last line is $(tail -n 1 err.txt)"
}

test_renders() {
  for signal in INT=130 TERM=143 HUP=129; do
    rm -f out.exr*
    # shellcheck disable=SC2086
    start render $scene --time 100 -o out.exr --resume
    kill "-${signal%=*}" "$process"
    ended "${signal#*=}" "SIG${signal%=*}"
    expect 0 info out.exr --json
    said out.txt '"tyndall.complete": "0"'
    present out.exr.state
    absent out.exr.state.lock
  done
  start render builtin:cube_g0 --method dom --size 2048x2048 -D render.dom.resolution=96 -o none.exr
  kill -TERM "$process"
  ended 143 SIGTERM
  absent none.exr
}

test_other_commands() {
  start bake builtin:cornell_fog --grid 8,8,8 --spp 1000000 -o baked
  kill -HUP "$process"
  ended 129 SIGHUP
  valid_json baked/bake.json
  absent baked/bake.state.lock
  start compare builtin:cornell_fog --size 128x96 --spp 1000 --methods path --reference-time 100 -o compared
  kill -TERM "$process"
  finished 143
  said err.txt 'tyndall: interrupted'
  expect 0 render builtin:cube_g0 -o depth.exr --aov depth --size 512x512 --spp 1 -q
  start screen depth.exr --medium fog:5 --variant reference -o screened.exr
  kill -TERM "$process"
  ended 143 SIGTERM
  absent screened.exr
  no_temporary_files
}

# Commands that read, and then write: ended while they read, they leave nothing, and later, all.
test_conversions() {
  head -c 16777216 /dev/zero > zeros.raw
  for wait in 0.01 0.05 0.2; do
    rm -f out.vdb
    what="tyndall convert, after $wait s"
    "$tyndall" convert zeros.raw out.vdb --raw-size 256,256,256 2> err.txt &
    process=$!
    sleep "$wait"
    kill -TERM "$process" 2> /dev/null
    wait "$process"
    status=$?
    checks=$((checks + 1))
    case $status in
    0) expect 0 info out.vdb ;;
    143) absent out.vdb ;;
    *) fail "exit status $status" ;;
    esac
    no_temporary_files
  done
}

# A volume that is mapped becomes shorter: its pages are lost, and the program ends by a signal that it catches.
test_lost_files() {
  cat > bricks.json << 'END'
{"tyndall": 1,
 "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "fov_y": 40, "resolution": [64, 48]},
 "media": [{"density": {"file": "noise.bricks"}, "bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 3, "sigma_a": 0.1}],
 "lights": [{"type": "directional", "direction": [1, -1, 0], "irradiance": [3, 3, 3]}],
 "render": {"method": "path", "spp": 100000}}
END
  head -c 262144 /dev/urandom > noise.raw
  expect 0 convert noise.raw noise.bricks --raw-size 64,64,64
  start render bricks.json -o lost.exr
  truncate -s 5000 noise.bricks
  finished 2
  checks=$((checks + 1))
  [ "$(grep -c '^tyndall: ' err.txt)" -eq 1 ] || fail "not one line: $(grep '^tyndall: ' err.txt)"
  said err.txt '^tyndall: .*/noise.bricks: it became shorter while it was read, or its disk failed$'
  absent lost.exr
  usage_error 'noise.bricks: 5000 bytes, of which its head accounts for' render bricks.json -o lost.exr
  no_temporary_files
}

test_tools() {
  "$tyndall" figure list > /dev/null 2>&1 || return 0
  start figure lpv-truth -o figures
  kill -TERM "$process"
  finished 143
  said err.txt 'interrupted'
}

# Both signals are there when the process goes on: the first is noted, the second ends it at once.
test_second_signal() {
  rm -f out.exr*
  # shellcheck disable=SC2086
  start render $scene --time 100 -o out.exr --resume
  kill -STOP "$process"
  kill -HUP "$process"
  kill -TERM "$process"
  kill -CONT "$process"
  # Threads may take them in either order; whichever is the second one ends the command.
  finished '(143|129)'
  said err.txt 'interrupted by SIG(TERM|HUP)'
  absent out.exr
  absent out.exr.state.lock
}

# As under nohup.
test_ignored_hangup() {
  trap '' HUP
  # shellcheck disable=SC2086
  start render $scene --time 100 -o out.exr
  trap - HUP
  kill -HUP "$process"
  sleep 0.5
  checks=$((checks + 1))
  kill -0 "$process" 2> /dev/null || fail "ended by a hangup that it should ignore"
  kill -INT "$process"
  ended 130 SIGINT
}

test_readers_that_leave() {
  for command in "help render" "info builtin:cornell_fog" "--version"; do
    what="tyndall $command, not read"
    # shellcheck disable=SC2086
    { "$tyndall" $command 2> err.txt; echo $? > status.txt; } | true
    # shellcheck disable=SC2086
    (sleep 0.3; exec "$tyndall" $command 2> err.txt; ) | true
    status=${PIPESTATUS[0]}
    checks=$((checks + 2))
    [ "$status" -eq 141 ] || fail "exit status $status instead of 141"
    [ ! -s err.txt ] || fail "said $(cat err.txt)"
  done
  what="tyndall render, whose progress nobody reads"
  (sleep 0.3; exec "$tyndall" render builtin:cube_g0 --size 64x64 --spp 64 -o read.exr --progress json 2>&1 > out.txt) | true
  status=${PIPESTATUS[0]}
  checks=$((checks + 1))
  [ "$status" -eq 0 ] || fail "exit status $status"
  expect 0 info read.exr
  what="tyndall help, to a full disk"
  "$tyndall" help render > /dev/full 2> err.txt
  status=$?
  checks=$((checks + 1))
  [ "$status" -eq 1 ] || fail "exit status $status instead of 1"
  said err.txt 'cannot be printed: No space left'
}

# Files that are opened while descriptors 0 to 2 are closed must not get progress and closing lines.
test_closed_streams() {
  expect 0 render builtin:cube_g0 --size 32x32 --spp 4 -o open.exr --png open.png -q
  for streams in '<&-' '>&-' '2>&-' '<&- >&- 2>&-'; do
    rm -f closed.*
    what="tyndall render $streams"
    # shellcheck disable=SC2016
    { eval '"$tyndall" render builtin:cube_g0 --size 32x32 --spp 4 -o closed.exr --png closed.png --progress json' \
      "$streams"; } > out.txt 2> err.txt
    status=$?
    checks=$((checks + 2))
    case " $streams" in
    *' >&-'*) wanted=1 ;; # the closing line cannot be printed
    *) wanted=0 ;;
    esac
    [ "$status" -eq "$wanted" ] || fail "exit status $status instead of $wanted"
    same open.exr closed.exr
    cmp -s open.png closed.png || fail "the PNG is another one"
  done
}

# The lock of a state is open all the time, and progress must not go into it.
test_closed_streams_and_locks() {
  rm -f out.exr*
  # shellcheck disable=SC2086
  "$tyndall" render $scene --time 100 -o out.exr --resume --progress json < /dev/null > out.txt 2>&- &
  process=$!
  for _ in $(seq 100); do
    [ -s out.exr.state ] && break
    sleep 0.1
  done
  what="tyndall render --resume 2>&-"
  checks=$((checks + 1))
  [ "$(cat out.exr.state.lock)" = "$process" ] || fail "out.exr.state.lock has $(head -c 100 out.exr.state.lock)"
  kill -TERM "$process"
  finished 143
  expect 0 info out.exr
}

test_two_processes() {
  rm -f out.exr*
  # shellcheck disable=SC2086
  start render $scene --time 100 -o out.exr --resume
  present out.exr.state.lock
  mv err.txt first.txt
  first=$process
  # shellcheck disable=SC2086
  expect 1 render $scene --time 1 -o out.exr --resume
  said err.txt "^tyndall: out.exr.state: in use by another tyndall, process $first\$"
  checks=$((checks + 1))
  [ "$(wc -l < err.txt)" -eq 1 ] || fail "not one line"
  absent out.exr
  kill -9 "$first"
  wait "$first" 2> /dev/null
  what="tyndall render, after a kill"
  present out.exr.state.lock # which is stale
  : > out.exr.state.999999999-0.tmp
  # shellcheck disable=SC2086
  expect 0 render $scene --time 0.2 -o out.exr --resume
  absent out.exr.state.lock
  absent out.exr.state.999999999-0.tmp
  start bake builtin:cornell_fog --grid 8,8,8 --spp 1000000 -o both
  mv err.txt first.txt
  expect 1 bake builtin:cornell_fog --grid 8,8,8 -o both
  said err.txt '^tyndall: both/bake.state: in use by another tyndall'
  kill -TERM "$process"
  finished 143
  # Without a state both write, and each writes a whole image.
  what="two renders to one image"
  "$tyndall" render builtin:cube_g0 --size 64x64 --spp 8 -o one.exr -q &
  first=$!
  expect 0 render builtin:cube_g0 --size 64x64 --spp 8 -o one.exr -q
  wait "$first" || fail "the first one failed"
  expect 0 render builtin:cube_g0 --size 64x64 --spp 8 -o other.exr -q
  same one.exr other.exr
  no_temporary_files
}

# state_age LIMIT WALL WORK: of the WORK processor seconds of each thread until the kill, WALL seconds after the start, the state
# on disk lacks at most LIMIT. Its last whole record tells at bytes 128 and 136 after how many seconds of time and of
# processors, of all threads, it was written; a record's size is at byte 24.
state_age() {
  checks=$((checks + 1))
  python3 - out.exr.state "$@" "$(nproc)" << 'END' || fail "a kill after $2 s lost more than $1 s of work"
import struct, sys
try:
    state = open(sys.argv[1], "rb").read()
except FileNotFoundError:
    state = b""
limit, wall, work, threads = (float(a) for a in sys.argv[2:])
at, elapsed, processor = 0, 0.0, 0.0
while at + 160 <= len(state):
    size, = struct.unpack_from("<Q", state, at + 24)
    if at + size > len(state):
        break
    elapsed, processor = struct.unpack_from("<dd", state, at + 128)
    at += size
lost = work - processor / threads
print(f"killed after {wall} s: {lost:.2f} s of work lost, {wall - elapsed:.2f} s of time")
if at > 0 and not (0 < elapsed <= wall and elapsed / 20 < processor <= threads * wall + 1):
    sys.exit(f"a record after {elapsed} s, {processor} s of processors: these bytes are others")
sys.exit(lost > limit)
END
}

# work: processor seconds of each thread that the process has had.
work() {
  awk -v per_second="$(getconf CLK_TCK)" -v threads="$(nproc)" \
    '{ sub(/.*\) /, ""); printf "%.2f", ($12 + $13) / per_second / threads }' "/proc/$process/stat"
}

# killed_after SECONDS ARGUMENT...: of rendering, not of loading.
killed_after() {
  seconds=$1
  shift
  rm -f out.exr*
  # Without a guide, whose solve and pilot come before the first sample and count as time.
  start render "$@" --spp 1000000 -o out.exr --resume -D render.path.guide=none
  before="$(date +%s.%N) $(work)"
  sleep "$seconds"
  after="$(date +%s.%N) $(work)"
  kill -9 "$process"
  wait "$process" 2> /dev/null
  # shellcheck disable=SC2046
  state_age 5 $(echo "$before $after" | awk '{printf "%.2f %.2f", $3 - $1, $4 - $2}')
}

test_kills() {
  command -v python3 > /dev/null || return 0
  if [ -z "${TYNDALL_IN_FULL:-}" ]; then
    killed_after 6 builtin:cornell_fog --size 640x480
    return
  fi
  for seconds in 1 2 3 4 5 6 7 8 9 10 11 12; do
    killed_after $seconds builtin:cornell_fog --size 640x480
    killed_after $seconds builtin:cornell_fog --size 1920x1080
    killed_after $seconds builtin:nebulae --method path --size 1920x1080 --aov all
    killed_after $seconds builtin:cloud_sun --method path --size 640x360
  done
}

test_renders
test_other_commands
test_conversions
test_lost_files
test_tools
test_second_signal
test_ignored_hangup
test_readers_that_leave
test_closed_streams
test_closed_streams_and_locks
test_two_processes
test_kills
finish 90
