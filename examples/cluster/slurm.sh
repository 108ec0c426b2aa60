#!/bin/bash
#SBATCH --job-name=skyshed
#SBATCH --cpus-per-task=1
#SBATCH --mem=4G
#SBATCH --requeue
# A map in N shards, one for each task of an array:
#
#   mkdir -p out
#   sbatch --array=1-100 slurm.sh 100 map dsm.tif --uavs sites.csv --radius 2000 --layers count -o 'out/{row}-{col}.tif'
#
# A task that is preempted or runs out of time is queued again; what it had done is left alone. Then `skyshed jobs status map …`
# tells what is missing, and `skyshed jobs merge` joins all. `--array=3,17` runs some shards again.
n=$1
shift
exec skyshed "$@" --resume --quiet --threads "${SLURM_CPUS_PER_TASK:-1}" --shard "$SLURM_ARRAY_TASK_ID/$n"
