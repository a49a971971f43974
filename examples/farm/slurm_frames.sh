#!/bin/bash
# Frames of a sequence as an array of Slurm jobs, without MPI. Submitted again, it renders what is missing.
# usage: slurm_frames.sh SCENE OUT_####.exr FRAMES JOBS [options of tyndall render]   (in a folder that all nodes share)
set -eu
scene=$1 out=$2 frames=$3 jobs=$4
shift 4
sbatch --parsable --array=1-"$jobs" --requeue --output=frames.%a.log --wrap \
  "tyndall render $(printf '%q ' "$scene" "$@") --frames $frames --part \$SLURM_ARRAY_TASK_ID/$jobs --resume --threads \$SLURM_CPUS_ON_NODE -o $(printf '%q' "$out")"
