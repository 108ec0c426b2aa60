#!/bin/bash
#SBATCH --job-name=skyshed
#SBATCH --array=1-100
#SBATCH --cpus-per-task=1
#SBATCH --mem=4G
#SBATCH --requeue
# A map in as many shards as the array has tasks:
#
#   sbatch slurm.sh map dsm.tif --uavs sites.csv --radius 2000 --layers count -o 'out/{row}-{col}.tif'
#
# A task that is preempted or runs out of time is queued again; what it had done is left alone. Then `skyshed jobs status map …`
# tells what is missing, and `skyshed jobs merge` joins all.
exec skyshed "$@" --resume --quiet --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
