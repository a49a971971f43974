#!/bin/bash
#SBATCH --ntasks=2
#SBATCH --requeue
# One command on all tasks of a Slurm job by Open MPI's mpirun, which learns of the nodes from Slurm. After a requeue
# --resume goes on, also with another number of tasks.
# usage: sbatch --nodes=8 --ntasks-per-node=1 --cpus-per-task=32 slurm_mpi.sh render SCENE -o OUT.exr --resume
mpirun --bind-to none --enable-recovery -n "$SLURM_NTASKS" tyndall "$@" --threads "${SLURM_CPUS_PER_TASK:-1}"
