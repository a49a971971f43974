# What the tests of the command line tool share: running it, and looking at what came of it. Sourced, with the program
# as $1, in a scratch folder, which is emptied.
set -u
tyndall=$1
. "$(dirname "${BASH_SOURCE[0]}")/scratch.sh"
checks=0
failures=0

# expect STATUS ARGUMENT...: runs tyndall; what it printed is in out.txt and err.txt.
expect() {
  wanted=$1
  shift
  "$tyndall" "$@" > out.txt 2> err.txt < /dev/null
  status=$?
  what="tyndall $*"
  checks=$((checks + 1))
  [ "$status" -eq "$wanted" ] || fail "exit status $status instead of $wanted: $(head -c 500 err.txt)"
}

fail() {
  failures=$((failures + 1))
  echo "FAILED: $what: $1"
}

# said FILE PATTERN: FILE has a line that matches the extended regular expression; unsaid: it has none.
said() {
  checks=$((checks + 1))
  grep -Eq -- "$2" "$1" || fail "$1 lacks /$2/: $(head -c 500 "$1")"
}
unsaid() {
  checks=$((checks + 1))
  ! grep -Eq -- "$2" "$1" || fail "$1 has /$2/: $(head -c 500 "$1")"
}

present() {
  checks=$((checks + 1))
  [ -s "$1" ] || fail "$1 is missing or empty"
}
absent() {
  checks=$((checks + 1))
  [ ! -e "$1" ] || fail "$1 is there"
}

# usage_error PATTERN ARGUMENT...: status 2, one line on stderr that matches, nothing on stdout.
usage_error() {
  pattern=$1
  shift
  expect 2 "$@"
  said err.txt "^tyndall: .*$pattern"
  checks=$((checks + 1))
  [ "$(wc -l < err.txt)" -eq 1 ] || fail "not one line: $(cat err.txt)"
  [ ! -s out.txt ] || fail "printed: $(head -c 200 out.txt)"
}

valid_json() {
  command -v python3 > /dev/null || return 0
  checks=$((checks + 1))
  python3 -m json.tool "$1" > /dev/null 2>&1 || fail "$1 is not JSON: $(head -c 500 "$1")"
}

# start ARGUMENT...: a render in the background that says on stderr when it is under way.
start() {
  what="tyndall $*"
  : > err.txt # here and not by the child, or what the last run said would be taken for progress
  "$tyndall" "$@" --progress json > out.txt 2> err.txt < /dev/null &
  process=$!
  for _ in $(seq 200); do
    [ -s err.txt ] && return
    sleep 0.1
  done
  fail "no progress within 20 s"
}

# finished STATUS: what was started ends with it, a pattern, and soon.
finished() {
  for _ in $(seq 600); do
    kill -0 "$process" 2> /dev/null || break
    sleep 0.1
  done
  kill -KILL "$process" 2> /dev/null && fail "still running after 60 s"
  wait "$process"
  status=$?
  checks=$((checks + 1))
  [[ $status =~ ^$1$ ]] || fail "exit status $status instead of $1: $(tail -n 2 err.txt)"
}

# same A.exr B.exr: no value of R, G, B differs.
same() {
  expect 0 diff "$1" "$2"
  said out.txt '^values that differ: 0$'
}

different() {
  expect 0 diff "$1" "$2"
  unsaid out.txt '^values that differ: 0$'
}

# small_by METHOD SCENE OUT ARGUMENT...: an image by a method with the options in $small.
small_by() {
  method=$1
  scene=$2
  out=$3
  shift 3
  # shellcheck disable=SC2086 # options
  expect 0 render "$scene" -o "$out" --method "$method" $small "$@"
}

# named_by_scenes METHOD SETTINGS: a scene that names the method, with the settings of $small, has the same image; and
# threads do not matter.
named_by_scenes() {
  small_by "$1" fog.json asked.exr
  expect 0 render fog.json -o named.exr --size 24x16 -q -D "render={\"method\": \"$1\", \"$1\": $2}"
  same asked.exr named.exr
  small_by "$1" fog.json again.exr --threads 1
  same asked.exr again.exr
}

# changed_by METHOD SCENE KEY=VALUE...: each, below render.METHOD, makes another image than there is without;
# kept_by: the same one.
changed_by() {
  each_option different "$@"
}
kept_by() {
  each_option same "$@"
}
each_option() {
  how=$1
  by=$2
  of=$3
  shift 3
  small_by "$by" "$of" plain.exr
  for option in "$@"; do
    small_by "$by" "$of" other.exr -D "render.$by.$option"
    $how plain.exr other.exr
  done
}

# channels METHOD AOVS NAMES MISSING: with AOVS an image has channels of those NAMES, too, and is the same; MISSING are
# refused, and so are parts of frames.
channels() {
  small_by "$1" fog.json all.exr --aov "$2"
  expect 0 info all.exr
  for channel in R G B $3; do said out.txt "^$channel "; done
  small_by "$1" fog.json plain.exr
  same all.exr plain.exr
  for aov in $4; do
    usage_error "--aov: the method $1 has no '$aov'" render fog.json -o no.exr --method "$1" --aov "$aov"
  done
  usage_error "--crop: the method $1 renders whole frames" render fog.json -o no.exr --method "$1" --crop 0,0,8x8
  absent no.exr
}

# statistics METHOD LISTS NUMBERS: stats.json has them.
statistics() {
  valid_json stats.json
  said stats.json "\"method\": \"$1\""
  for name in $2; do said stats.json "\"$name\": \\["; done
  for name in $3; do said stats.json "\"$name\": [0-9.e-]+"; done
  unsaid stats.json 'nan|inf'
}

# interrupted ARGUMENT...: a render to cut.exr and cut.png that is told to end leaves neither.
interrupted() {
  start render "$@" -o cut.exr --png cut.png --size 4096x4096
  kill -INT "$process"
  finished 130
  absent cut.exr
  absent cut.png
}

# fog.json, a cube in sun and sky; room.json, with surfaces and the lights in $1; empty.json.
write_scenes() {
  cat > fog.json << 'END'
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": [2, 3, 4], "sigma_a": 0.1, "g": 0.6}],
  "lights": [
    {"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 1},
    {"type": "environment", "radiance": [0.1, 0.2, 0.3]}
  ]
}
END
  cat > room.json << END
{
  "tyndall": 1,
  "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "fov_y": 40},
  "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 0.5, "sigma_a": 0.1}],
  "lights": [$1],
  "geometry": [
    {"quad": {"origin": [-5, -1, 5], "u": [10, 0, 0], "v": [0, 0, -10]}, "material": {"albedo": 0.5}},
    {"sphere": {"center": [0, -0.4, 0], "radius": 0.5}, "material": {"albedo": 0.8}}
  ]
}
END
  echo '{"tyndall": 1, "camera": {"position": [0, 1, 5], "target": [0, 0, 0]}}' > empty.json
}

# needs_media METHOD SAYER: a scene without media is refused, and the message begins with SAYER.
needs_media() {
  usage_error "$2: the scene has no media" render empty.json -o no.exr --method "$1"
  absent no.exr
}

# compares METHODS ARGUMENT...: tyndall compare by METHODS, one after another with blanks, leaves an image of each.
compares() {
  by=$1
  shift
  expect 0 compare fog.json --methods "${by// /,}" --size 16x16 --spp 4 --reference-spp 64 -o compared -q "$@"
  for method in $by; do present "compared/$method.exr"; done
}

# surfaces_by_paths METHOD: surfaces come from paths, and are as noisy; depth is theirs. Leaves few.exr, at --spp 1.
surfaces_by_paths() {
  small_by "$1" room.json few.exr --spp 1 --aov depth
  small_by "$1" room.json many.exr --spp 16
  different few.exr many.exr
  expect 0 info few.exr
  said out.txt '^depth.Z  *[0-9.]+  *[1-9]'
}

# refused_options METHOD: of each line of stdin the first word, KEY=VALUE below render.METHOD, is refused with what follows.
refused_options() {
  while read -r option words; do
    usage_error "$words" render fog.json -o no.exr --method "$1" -D "render.$1.$option"
    absent no.exr
  done
}

no_temporary_files() {
  checks=$((checks + 1))
  [ -z "$(find . -name '*tmp*')" ] || fail "temporary files are left: $(find . -name '*tmp*')"
}

# run_tests LEAST: runs all functions test_..., and ends with their result.
run_tests() {
  for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
  no_temporary_files
  finish "$1"
}

# finish LEAST: the result of the whole test; at least so many checks were made.
finish() {
  echo "$checks checks, $failures failed"
  [ "$failures" -eq 0 ] && [ "$checks" -ge "$1" ]
}
