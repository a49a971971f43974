#!/usr/bin/env bash
# Commands of several processes under mpirun, and parts without it. usage: test_farm.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"
. "$(dirname "$0")/bake_level.sh"

# What Open MPI needs for four ranks on any machine, also as root.
mpirun="mpirun --allow-run-as-root --oversubscribe -q"
module=$(dirname "$tyndall")/tyndall-mpi.so
frames=12
[ -z "${TYNDALL_IN_FULL:-}" ] || frames=240

# ranks STATUS N ARGUMENT...: tyndall by N ranks of one thread each.
ranks() {
  wanted=$1
  count=$2
  shift 2
  # shellcheck disable=SC2086
  timeout 120 $mpirun -n "$count" "$tyndall" "$@" --threads 1 > out.txt 2> err.txt < /dev/null
  status=$?
  what="mpirun -n $count tyndall $*"
  checks=$((checks + 1))
  [ "$status" -eq "$wanted" ] || fail "exit status $status instead of $wanted: $(head -c 800 err.txt)"
}

# start_ranks N OPTIONS ARGUMENT...: the same in the background, with options of mpirun.
start_ranks() {
  count=$1
  options=$2
  shift 2
  what="mpirun -n $count tyndall $*"
  # shellcheck disable=SC2086
  timeout 120 $mpirun $options -n "$count" "$tyndall" "$@" --threads 1 > out.txt 2> err.txt < /dev/null &
  process=$!
}

# find_rank RANK: $victim is the process of that rank of the ranks that were started, once there is one.
find_rank() {
  victim=
  wait_for is_rank "$1"
}
children() {
  cat "/proc/$1/task/$1/children" 2> /dev/null
}
is_rank() {
  local launcher rank
  for launcher in $(children "$process"); do # of timeout
    for rank in $(children "$launcher"); do
      if grep -zqx "OMPI_COMM_WORLD_RANK=$1" "/proc/$rank/environ" 2> /dev/null; then
        victim=$rank
        return 0
      fi
    done
  done
  return 1
}

kill_victim() {
  [ -n "$victim" ] && kill -9 "$victim" 2> /dev/null || fail "it had ended before it could be killed"
}

# one_line PATTERN: what tyndall said on stderr is one line that matches; mpirun adds lines of its own.
one_line() {
  said err.txt "^tyndall: .*$1"
  checks=$((checks + 1))
  [ "$(grep -c '^tyndall: ' err.txt)" -eq 1 ] || fail "not one line: $(grep '^tyndall: ' err.txt)"
}

# wait_for COMMAND...: until it succeeds, at most a minute, or until what was started has ended.
wait_for() {
  for _ in $(seq 3000); do
    "$@" && return
    kill -0 "$process" 2> /dev/null || break
    sleep 0.02
  done
  "$@" && return
  fail "it ended, or a minute was over, before this was so: $*"
}

# at_least N FOLDER: so many images are there.
at_least() {
  [ "$(find "$2" -name '*.exr' | wc -l)" -ge "$1" ]
}

# Rendered volumes: a ball of smoke that rises through 8 x 8 x 8 voxels, solved in 32 x 32 x 32 cells.
make_smoke() {
  python3 - "$frames" << 'END'
import math, struct, sys
count = int(sys.argv[1])
for frame in range(1, count + 1):
    up, aside = 0.5 + 6 * frame / (count + 1), 3.5 + math.sin(0.3 * frame)
    values = [math.exp(-((x - aside) ** 2 + (y - up) ** 2 + (z - 3.5) ** 2) / 4)
              for z in range(8) for y in range(8) for x in range(8)]
    with open(f'smoke_{frame:04d}.nrrd', 'wb') as file:
        file.write(b'NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nspace dimension: 3\n'
                   b'space directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)\nspace origin: (-0.875,-0.875,-0.875)\n'
                   b'encoding: raw\nendian: little\n\n')
        file.write(struct.pack('<512f', *values))
END
  cat > smoke.json << 'END'
{"tyndall": 1,
 "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "fov_y": 40, "resolution": [32, 24]},
 "media": [{"density": {"file": "smoke_####.nrrd"}, "bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 3, "sigma_a": 0.1}],
 "lights": [{"type": "directional", "direction": [1, -1, 0], "irradiance": [3, 3, 3]}],
 "render": {"method": "dom", "spp": 2, "dom": {"resolution": 32}}}
END
}

# A volume of bricks, of which every rank has one page in memory, or as few as the system leaves it.
test_bricks() {
  python3 -c 'import sys; sys.stdout.buffer.write(bytes(i * i % 251 for i in range(48 ** 3)))' > noise.raw
  expect 0 convert noise.raw noise.bricks --raw-size 48,48,48
  for file in raw bricks; do
    raw=
    [ $file = bricks ] || raw=', "raw": {"size": [48, 48, 48]}'
    cat > $file.json << END
{"tyndall": 1,
 "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "fov_y": 40, "resolution": [32, 24]},
 "media": [{"density": {"file": "noise.$file"$raw}, "bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 0.02, "sigma_a": 0.001}],
 "lights": [{"type": "directional", "direction": [1, -1, 0], "irradiance": [3, 3, 3]}],
 "render": {"method": "path", "spp": 8}}
END
  done
  expect 0 render raw.json -o one.exr
  ranks 0 2 render bricks.json -o two.exr --resident 1
  same one.exr two.exr
  ranks 0 4 render bricks.json -o four.exr
  same one.exr four.exr
}

test_parts() {
  scene="builtin:cornell_fog --method path --spp 8 --size 40x31 --aov variance -q"
  # shellcheck disable=SC2086
  expect 0 render $scene -o whole.exr
  for part in 1 2 3; do
    # shellcheck disable=SC2086
    expect 0 render $scene -o part$part.exr --part $part/3
  done
  expect 0 merge part1.exr part2.exr part3.exr -o merged.exr -q
  same whole.exr merged.exr
  usage_error "0/3' is not a part" render builtin:cornell_fog -o x.exr --part 0/3
  usage_error 'method fld renders whole frames' render builtin:cornell_fog -o x.exr --part 1/3 --method fld
  usage_error '31 rows are fewer than 32' render builtin:cornell_fog -o x.exr --part 1/32 --method path --size 40x31
}

test_sequence_options() {
  usage_error 'has no ####' render smoke.json -o x.exr --frames 1-3
  usage_error "'3-1'" render smoke.json -o x_##.exr --frames 3-1
  usage_error "'1-3:'" render smoke.json -o x_##.exr --frames 1-3:
  usage_error 'is not like 1-240' render smoke.json -o x_##.exr --frames one
  usage_error 'give --frames' render smoke.json -o x.exr --chain 4
  usage_error '.exr images' render smoke.json -o x_##.png --frames 1-3 --resume
  usage_error 'Method auto' render smoke.json -o x_##.exr --frames 1-3 --method auto
  usage_error 'smoke_0998' render smoke.json -o x_##.exr --frames 998-999:2
}

# Frames by one process, which parts and ranks are held against. The same command again leaves them; chains matter.
test_sequence() {
  mkdir one parts
  expect 0 render smoke.json -o one/f_####.exr --frames 1-$frames --chain 4 --threads 1 --stats one.json
  said one.json "\"frames_rendered\": $frames"
  expect 0 render smoke.json -o one/f_####.exr --frames 1-$frames --chain 4 --resume
  said out.txt "^$frames of $frames frames were finished before"
  unsaid out.txt 'rank 0'
  # A warm start saves sweeps and stays within the tolerance.
  expect 0 render smoke.json -o cold.exr -D frame=4 -q
  expect 0 diff one/f_0004.exr cold.exr
  for part in 1 2; do
    expect 0 render smoke.json -o parts/f_####.exr --frames 1-$frames --chain 4 --part $part/2 -q
  done
  same_frames parts
}

same_frames() {
  checks=$((checks + 1))
  [ "$(find "$1" -name '*.exr' | wc -l)" -eq $frames ] || fail "frames are missing: $(ls "$1")"
  checks=$((checks + 1))
  [ "$(find "$1" -type f | wc -l)" -eq $frames ] || fail "there are more files than frames: $(ls "$1")"
  for file in one/*.exr; do same "$file" "$1/${file#one/}"; done
}

test_image() {
  scene="builtin:cornell_fog --method path --spp 24 --size 48x36 --aov all,half -q"
  # shellcheck disable=SC2086
  expect 0 render $scene -o whole.exr --threads 1
  # shellcheck disable=SC2086
  ranks 0 4 render $scene -o four.exr
  same whole.exr four.exr
}

# A rank that dies ends the job; what the others did is in the state, and another number of ranks goes on from it.
test_killed() {
  scene="builtin:cornell_fog --method path --spp 200 --size 64x48 -q"
  # shellcheck disable=SC2086
  expect 0 render $scene -o whole.exr
  # shellcheck disable=SC2086
  start_ranks 4 "" render $scene -o "$PWD/killed.exr" --resume --checkpoint 0.05
  find_rank 2
  wait_for test -s killed.exr.state
  kill_victim
  wait "$process"
  checks=$((checks + 1))
  [ ! -e killed.exr ] || fail "it was finished before it could be killed"
  # shellcheck disable=SC2086
  ranks 0 2 render $scene -o "$PWD/killed.exr" --resume
  same whole.exr killed.exr
}

# With Open MPI's recovery the others go on, and rank 0 traces the share of the dead one. Its launcher may stay for ever
# after its ranks have ended ("PMIX ERROR: BAD-PARAM", seen with 4.1.4 on a machine under load), so that the ranks are
# waited for, and then it has some seconds for its status.
test_recovery() {
  # shellcheck disable=SC2086
  start_ranks 3 --enable-recovery render $scene -o "$PWD/lost.exr" --resume --checkpoint 0.05
  find_rank 1
  wait_for test -s lost.exr.state
  kill_victim
  launcher=$(children "$process")
  wait_for test -s lost.exr
  written=$(date +%s)
  # Nobody waits for the dead: measured 0.1 s, with time for a machine under load.
  wait_for no_ranks "$launcher"
  checks=$((checks + 1))
  [ $(($(date +%s) - written)) -lt 5 ] || fail "its ranks ended $(($(date +%s) - written)) s after its image"
  for _ in $(seq 100); do
    kill -0 "$process" 2> /dev/null || break
    sleep 0.05
  done
  if kill -9 "$launcher" 2> /dev/null; then
    echo "note: mpirun stayed after its ranks had ended: $(head -c 200 err.txt)"
    wait "$process" 2> /dev/null
  else
    wait "$process"
    status=$?
    checks=$((checks + 1))
    [ $status -eq 0 ] || fail "exit status $status: $(head -c 500 err.txt)"
  fi
  same whole.exr lost.exr
}
no_ranks() {
  local rank
  for rank in $(children "$1"); do
    grep -qs '^State:.*[RSDT]' "/proc/$rank/status" && return 1
  done
  return 0
}

test_shared_sequence() {
  mkdir four
  ranks 0 4 render smoke.json -o four/f_####.exr --frames 1-$frames --chain 4 --stats four.json
  said four.json '"ranks": 4'
  said out.txt "$frames of $frames frames"
  same_frames four
}

# Whichever rank is killed, finished frames stay, and none is missing in the end.
test_killed_sequence() {
  for rank in 0 2; do
    rm -rf killed
    mkdir killed
    start_ranks 3 "" render smoke.json -o "$PWD/killed/f_####.exr" --frames 1-$frames --chain 4 --resume
    find_rank $rank
    wait_for at_least 1 killed
    kill_victim
    wait "$process"
    ranks 0 2 render smoke.json -o "$PWD/killed/f_####.exr" --frames 1-$frames --chain 4 --resume
    rm -f killed/*.tmp
    same_frames killed
  done
}

# Lightmaps with padding, seams and denoising, vertices, a grid and probes in fog, by one process; ranks and parts are
# held against it.
bake="fog.json --lightmaps --vertices --size 24x16 --spp 32 --denoise --grid 3,2,3 --probes points.json --cache 4"
bake="$bake --cache-paths 4 -q"
baked="the_room_1.exr the_room_1.denoised.exr sign.exr sign_2.exr grid.exr probes.json"
test_bake() {
  make_level
  echo '{"positions": [[0, 1, 0], [0.5, 0.4, -0.2], [-0.5, 0.1, 0.6]]}' > points.json
  sed 's/"lights"/"media": [{"sigma_s": 0.8, "sigma_a": 0.1, "bounds": [[-1, 0, -1], [1, 2, 1]]}], "lights"/' level.json > fog.json
  # shellcheck disable=SC2086
  expect 0 bake $bake -o bake1 --threads 1
}
same_bake() {
  for file in $baked; do
    checks=$((checks + 1))
    cmp "bake1/$file" "$1/$file" || fail "the bakes differ"
  done
}

test_bake_parts() {
  for part in 2 4 1 3; do
    # shellcheck disable=SC2086
    expect 0 bake $bake -o parted --part $part/4
  done
  absent parted/bake.json
  # shellcheck disable=SC2086
  expect 0 bake $bake -o parted --merge 4
  same_bake parted
  # A part that is there is left; one of other options, and one that is missing or damaged, is told.
  # shellcheck disable=SC2086
  expect 0 bake ${bake% -q} -o parted --part 3/4 --resume
  said out.txt '^part 3 of 4 was finished before'
  # shellcheck disable=SC2086
  usage_error 'part-1-of-4.light: a part of another bake' bake $bake -o parted --merge 4 --seed 3
  truncate -s -8 parted/part-3-of-4.light
  # shellcheck disable=SC2086
  usage_error 'part-3-of-4.light: the file of a part that is cut short' bake $bake -o parted --merge 4
  rm parted/part-2-of-4.light
  # shellcheck disable=SC2086
  usage_error 'part-2-of-4.light: No such file' bake $bake -o parted --merge 4
  usage_error "'5/4' is not a part" bake fog.json -o parted --part 5/4
  usage_error 'give one' bake fog.json -o parted --part 1/4 --merge 4
  usage_error '--error looks at all receivers' bake fog.json -o parted --part 1/4 --error 0.1
  usage_error 'virtual emitters from all receivers' bake fog.json -o parted --part 1/4 --method impulse
}

test_shared_bake() {
  # shellcheck disable=SC2086
  ranks 0 4 bake $bake -o bake4 --stats bake4.json
  same_bake bake4
  said bake4.json '"ranks": 4'
  said bake4.json '"messages": [1-9]'
  # Each rank finds the virtual emitters of impulse responses, from all receivers.
  impulse="fog.json --lightmaps --vertices --size 24x16 --spp 8 --method impulse -q"
  # shellcheck disable=SC2086
  expect 0 bake $impulse -o impulse1 --threads 1
  # shellcheck disable=SC2086
  ranks 0 3 bake $impulse -o impulse3
  for file in the_room_1.exr sign.exr; do
    checks=$((checks + 1))
    cmp impulse1/$file impulse3/$file || fail "the bakes differ"
  done
}

test_compare() {
  compare="builtin:cornell_fog --methods fld --reference-spp 4 --size 16x12 -q"
  # shellcheck disable=SC2086
  expect 0 compare $compare -o compare1 --threads 1
  # shellcheck disable=SC2086
  ranks 0 3 compare $compare -o compare3
  same compare1/reference.exr compare3/reference.exr
}

# Grids are divided, and images do not depend on that; what is not divided rank 0 solves, and a line says so.
test_divided() {
  fld="builtin:nebulae --method fld --size 32x24 -D render.fld.ratio=1 -D render.fld.resolution=40 -q"
  # shellcheck disable=SC2086
  expect 0 render $fld -o fld1.exr --threads 1 --stats fld1.json
  said fld1.json '"solve_ranks": 1'
  for count in 2 4; do
    # shellcheck disable=SC2086
    ranks 0 $count render $fld -o fld$count.exr --stats fld$count.json
    said fld$count.json "\"solve_ranks\": $count"
    same fld1.exr fld$count.exr
  done
  fluence="builtin:nebulae --method fld --size 16,16,16 -D render.fld.ratio=1 -D render.fld.resolution=40 -q"
  # shellcheck disable=SC2086
  expect 0 fluence $fluence -o fluence1.vti
  # shellcheck disable=SC2086
  ranks 0 3 fluence $fluence -o fluence3.vti
  checks=$((checks + 1))
  cmp fluence1.vti fluence3.vti || fail "the fluences differ"
  ranks 0 2 render builtin:nebulae --method fld --size 16x12 -D render.fld.resolution=24 -o small.exr
  said err.txt 'rank 0 solves for diffusion on .* alone: there are too few cells'
  # Surfaces between cells, and over-relaxation.
  walls="builtin:cornell_fog --method fld --size 16x12 -D render.fld.ratio=1 -D render.fld.resolution=26 -q"
  sor="builtin:nebulae --method fld --size 16x12 -D render.fld.ratio=1 -D render.fld.resolution=24 -D render.fld.solver=sor -D render.fld.iterations=8 -q"
  for scene in "$walls" "$sor"; do
    # shellcheck disable=SC2086
    expect 0 render $scene -o alone.exr --threads 1
    # shellcheck disable=SC2086
    ranks 0 2 render $scene -o shared.exr --stats shared.json
    said shared.json '"solve_ranks": 2'
    same alone.exr shared.exr
  done
}

# A command without shares runs once; so does one that is not there.
test_alone() {
  ranks 0 3 info builtin:cornell_fog
  checks=$((checks + 1))
  [ "$(grep -c '^media' out.txt)" -le 1 ] || fail "printed several times: $(head -c 300 out.txt)"
  ranks 2 3 rendre builtin:cornell_fog
  one_line "did you mean 'render'"
  ranks 0 3 render --help
  checks=$((checks + 1))
  [ "$(grep -c 'Renders a scene to an image' out.txt)" -eq 1 ] || fail "help was printed several times"
}

# unlike STATUS ARGUMENTS -- COMMAND: rank 0 with the arguments, and another command as rank 1.
unlike() {
  local first=()
  wanted=$1
  shift
  while [ "$1" != -- ]; do
    first+=("$1")
    shift
  done
  shift
  what="mpirun tyndall ${first[*]} : tyndall $*"
  # shellcheck disable=SC2086
  timeout 60 $mpirun -n 1 "$tyndall" "${first[@]}" : -n 1 "$@" > out.txt 2> err.txt < /dev/null
  status=$?
  checks=$((checks + 1))
  [ $status -eq "$wanted" ] || fail "exit status $status instead of $wanted: $(head -c 500 err.txt)"
}

test_bad_input() {
  ranks 2 3 render nowhere.json -o x.exr
  one_line 'nowhere.json'
  ranks 2 3 render builtin:cornell_fog -o x.exr --spp none
  one_line "'none'"
  unlike 2 render builtin:cornell_fog -o x.exr -- "$tyndall" render builtin:cornell_fog -o x.exr --spp none
  one_line "rank 1: .*'none'"
  sed 's/"sigma_s": 3/"sigma_s": 4/' smoke.json > other.json
  mkdir apart
  cp smoke_0001.nrrd apart
  cp other.json apart/smoke.json
  render="render smoke.json -o x.exr --method path -D frame=1 -q"
  # shellcheck disable=SC2086
  unlike 2 $render -- "$tyndall" render apart/smoke.json -o x.exr --method path -D frame=1 -q
  one_line 'rank 1 on .* does not have what rank 0 has'
  rm apart/smoke_0001.nrrd
  # shellcheck disable=SC2086
  unlike 2 $render -- "$tyndall" render apart/smoke.json -o x.exr --method path -D frame=1 -q
  one_line 'rank 1 on .*smoke_0001.nrrd'
  # A frame that only rank 0 has.
  cp smoke_0001.nrrd smoke.json apart
  mkdir frames
  unlike 2 render smoke.json -o frames/f_####.exr --frames 1-$frames --chain 1 -- \
    "$tyndall" render apart/smoke.json -o frames/f_####.exr --frames 1-$frames --chain 1
  one_line 'rank 1: .*apart/smoke_0'
  # shellcheck disable=SC2086
  TYNDALL_RANKS_WAIT=2 unlike 2 $render -- sleep 30
  one_line 'a rank is missing'
  # A rank whose disk takes no more: as for one process, the work failed, and the input was right.
  mkdir full
  # shellcheck disable=SC2016
  unlike 1 render smoke.json -o full/f_####.exr --frames 1-$frames --chain 1 -D render.dom.resolution=16 -- \
    sh -c 'ulimit -f 1; exec "$0" "$@"' "$tyndall" render smoke.json -o full/f_####.exr --frames 1-$frames --chain 1 \
    -D render.dom.resolution=16
  one_line 'rank 1: .*full/f_'
  absent x.exr
}

# The program itself needs no MPI, and says so where it is started by one without its module.
test_without_module() {
  unsaid <(ldd "$tyndall" 2> /dev/null) 'libmpi'
  mkdir bare
  cp "$tyndall" bare/tyndall
  with_module=$tyndall
  tyndall=$PWD/bare/tyndall
  ranks 2 2 render builtin:cornell_fog -o x.exr
  one_line 'this build has no MPI'
  tyndall=$with_module
}

test_parts
if ! command -v python3 > /dev/null; then
  echo "skipped: sequences need python3, which writes their volumes"
  finish 9
  exit
fi
export XDG_CACHE_HOME=$PWD/cache # of impulse responses' tables
make_smoke
test_sequence_options
test_sequence
test_bake
test_bake_parts
if ! command -v mpirun > /dev/null || [ ! -e "$module" ]; then
  finish 20 || exit 1
  echo "skipped: ranks need Open MPI (mpirun) and a build with it; parts and sequences of one process were tested"
  exit 77
fi
test_image
test_bricks
test_killed
test_recovery
test_shared_sequence
test_killed_sequence
test_shared_bake
test_compare
test_divided
test_alone
test_bad_input
test_without_module
rm -f killed.exr.*.tmp lost.exr.*.tmp # of killed processes
no_temporary_files
finish 200
