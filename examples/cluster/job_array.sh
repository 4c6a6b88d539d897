#!/bin/bash
# A sweep as a SLURM job array, without a scheduler of Dask:
#     id=$(sbatch --parsable --array=1-64 job_array.sh)
#     sbatch --dependency=afterok:$id job_array.sh
# Each task does its share; the second command, which is no array, puts the shares together. All
# nodes must see this folder. A task that was ended goes on where it was when it is submitted again.
#SBATCH --job-name=springs
#SBATCH --cpus-per-task=1
#SBATCH --time=04:00:00
set -euo pipefail

share=(--join)
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  share=(--shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --workers "$SLURM_CPUS_PER_TASK")
fi
elastic-tendon sweep biorob_x4_joint_3 -o runs.parquet --runs "${RUNS:-1000000}" \
  --vary transmission.upper_spring.stiffness=5% --vary transmission.lower_spring.stiffness=5% \
  "${share[@]}"
