#!/usr/bin/env bash
# Method dom by four ranks of one command under mpirun, which divide its cells. usage: test_farm_dom.sh TYNDALL (empties
# the current folder)
. "$(dirname "$0")/cli.sh"

# What Open MPI needs for four ranks on any machine, also as root.
mpirun="mpirun --allow-run-as-root --oversubscribe -q"

# ranks N ARGUMENT...: tyndall by N ranks of one thread each.
ranks() {
  count=$1
  shift
  # shellcheck disable=SC2086
  timeout 120 $mpirun -n "$count" "$tyndall" "$@" --threads 1 > out.txt 2> err.txt < /dev/null
  status=$?
  what="mpirun -n $count tyndall $*"
  checks=$((checks + 1))
  [ "$status" -eq 0 ] || fail "exit status $status: $(head -c 800 err.txt)"
}

# close_to A B: images whose relative rms difference is below 1e-6 (1.5e-7 is measured), which --json tells.
close_to() {
  expect 0 diff "$1" "$2" --json
  checks=$((checks + 1))
  python3 - out.txt << 'END' || fail "$1 and $2 differ: $(head -c 400 out.txt)"
import json, sys
text = json.load(open(sys.argv[1]))
sys.exit(0 if text["all"]["relative_rmse"] < 1e-6 else 1)
END
}

sweeps() {
  python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["dom"]["sweeps"][0])' "$1"
}

# Walls, a cloud in the sun, and a forward peak.
test_images() {
  for scene in cornell_fog cloud_sun cube_g0.96; do
    render="builtin:$scene --method dom --size 32x24 --spp 1 -q -D render.dom.resolution=24 -D render.dom.directions=48"
    # shellcheck disable=SC2086
    expect 0 render $render -o one.exr --threads 1 --stats one.json
    for count in 2 4; do
      # shellcheck disable=SC2086
      ranks $count render $render -o many.exr --stats many.json
      unsaid err.txt 'alone'
      said many.json "\"ranks\": $count"
      close_to one.exr many.exr
      checks=$((checks + 1))
      [ "$(sweeps one.json)" -eq "$(sweeps many.json)" ] || fail "$(sweeps many.json) sweeps, $(sweeps one.json) by one"
    done
  done
}

test_other_commands() {
  ranks 3 fluence builtin:cube_g0.7 --method dom --size 8,8,8 -o fluence.vti
  unsaid err.txt 'alone'
  present fluence.vti
  ranks 3 compare builtin:cube_g0.7 --methods dom --reference-spp 2 --size 12x9 -o compare -q
  present compare/errors.json
}

# What is not divided is said in one line, and rank 0 does it.
test_alone() {
  render="builtin:cube_g0.7 --method dom --size 12x9 -D render.dom.resolution=12 -D media[0].sigma_s=1000"
  # shellcheck disable=SC2086
  ranks 2 render $render -o thick.exr
  said err.txt 'rank 0 solves alone, because cells are so thick'
  ranks 4 render builtin:cube_g0.7 --method dom --size 12x9 -D render.dom.resolution=6 -o few.exr
  said err.txt 'rank 0 solves alone, because it has too few cells'
}

module=$(dirname "$tyndall")/tyndall-mpi.so
if ! command -v mpirun > /dev/null || ! command -v python3 > /dev/null || [ ! -e "$module" ]; then
  echo "skipped: there is no mpirun, or this build has no MPI"
  exit 77
fi
test_images
test_other_commands
test_alone
finish 40
