#!/bin/bash
# A sweep on the cores of one SLURM job, dealt out by a Dask scheduler:
#     sbatch one_job.sh
# The first task is the scheduler, all others are workers; all nodes must see this folder.
#SBATCH --job-name=springs
#SBATCH --ntasks=65
#SBATCH --time=04:00:00
set -euo pipefail

file=scheduler.json
rm -f "$file"
trap 'kill $(jobs -p) 2>/dev/null || true' EXIT
srun --ntasks=1 --overlap dask scheduler --scheduler-file "$file" --no-dashboard &
srun --ntasks=$((SLURM_NTASKS - 1)) --overlap \
  dask worker --scheduler-file "$file" --nworkers 1 --nthreads 1 --no-dashboard &
until [ -s "$file" ]; do sleep 0.2; done
elastic-tendon sweep biorob_x4_joint_3 -o runs.parquet --runs "${RUNS:-1000000}" \
  --vary transmission.upper_spring.stiffness=5% --vary transmission.lower_spring.stiffness=5% \
  --scheduler-file "$file"
