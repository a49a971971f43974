#!/usr/bin/env bash
# Diffusion on divided grids against hypre's PFMG, by 1, 2 and 4 ranks: the same solution, and by one rank in less processor time.
# usage: test_hypre.sh PROGRAM [CELLS RUNS]; without a PROGRAM (libhypre-dev, MPI) it is skipped.
set -uo pipefail
program=${1:-}
if [ -z "$program" ] || [ ! -x "$program" ]; then
  echo "skipped: the comparison with hypre needs libhypre-dev and Open MPI"
  exit 77
fi
failed=0
for ranks in 1 2 4; do
  timeout 120 mpirun --allow-run-as-root --oversubscribe -q -n $ranks "$program" "${2:-40}" 1e-6 "${3:-1}" || {
    echo "FAILED with $ranks ranks" >&2
    failed=1
  }
done
exit $failed
