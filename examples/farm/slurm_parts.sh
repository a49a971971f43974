#!/bin/bash
# An image in parts as an array of Slurm jobs, without MPI, and a job that merges them.
# usage: slurm_parts.sh SCENE OUT.exr PARTS [options of tyndall render]   (in a folder that all nodes share)
set -eu
scene=$1 out=$2 parts=$3
shift 3
base=${out%.exr}
render=$(sbatch --parsable --array=1-"$parts" --requeue --output="$base.%a.log" --wrap \
  "tyndall render $(printf '%q ' "$scene" "$@") --part \$SLURM_ARRAY_TASK_ID/$parts --resume --threads \$SLURM_CPUS_ON_NODE -o $(printf '%q' "$base").part\$SLURM_ARRAY_TASK_ID.exr")
sbatch --parsable --dependency=afterok:"$render" --output="$base.merge.log" --wrap \
  "tyndall merge $(printf '%q' "$base").part*.exr -o $(printf '%q' "$out")"
