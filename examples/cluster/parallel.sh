#!/bin/sh
# A map in N shards by GNU parallel, on this machine or, with its --sshlogin, on several that share a folder:
#
#   mkdir -p out
#   sh parallel.sh 100 map dsm.tif --uavs sites.csv --radius 2000 --layers count -o 'out/{row}-{col}.tif'
#
# A shard that is killed is run again; what it had done is left alone. Run it again at any time.
set -eu
n=$1
shift
seq "$n" | parallel --quote --jobs "${JOBS:-100%}" --retries 20 \
    skyshed "$@" --resume --quiet --threads 1 --shard '{}'/"$n" || echo "some shards failed" >&2
skyshed jobs status "$@"
