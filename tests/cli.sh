# What the tests of the command line tool share: running it, and looking at what came of it. Sourced, with the program
# as $1, in a scratch folder, which is emptied.
set -u
tyndall=$1
if [ -e .git ] || [ -e CMakeLists.txt ] || [ "$PWD" = / ] || [ "$PWD" = "${HOME:-/}" ]; then
  echo "$0: the current folder would be emptied, and $PWD is not a scratch folder" >&2
  exit 2
fi
rm -rf ./*
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

# finished STATUS: what was started ends with it, and soon.
finished() {
  for _ in $(seq 600); do
    kill -0 "$process" 2> /dev/null || break
    sleep 0.1
  done
  kill -KILL "$process" 2> /dev/null && fail "still running after 60 s"
  wait "$process"
  status=$?
  checks=$((checks + 1))
  [ "$status" -eq "$1" ] || fail "exit status $status instead of $1: $(tail -n 2 err.txt)"
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

# finish LEAST: the result of the whole test; at least so many checks were made.
finish() {
  echo "$checks checks, $failures failed"
  [ "$failures" -eq 0 ] && [ "$checks" -ge "$1" ]
}
