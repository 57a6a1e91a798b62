#!/usr/bin/env bash
# Ends the Slurm that start.sh began in the same folder, with all jobs.  usage: stop.sh FOLDER
set -uo pipefail
folder=$(realpath -m "$1")
export SLURM_CONF="$folder/slurm.conf"

scancel --user="$(id -un)" 2>/dev/null
for _ in $(seq 20); do
    [ -z "$(squeue --noheader 2>/dev/null)" ] && break
    sleep 0.5
done
for name in slurmd.node1 slurmd.node2 slurmctld munged; do
    [ -s "$folder/$name.pid" ] || continue
    pid=$(cat "$folder/$name.pid")
    kill "$pid" 2>/dev/null
    # it writes its state until it is gone, and the folder is to be removed after us
    for _ in $(seq 20); do
        kill -0 "$pid" 2>/dev/null || break
        sleep 0.5
    done
done
# Only the link that start.sh made.
[ "$(readlink /etc/slurm/slurm.conf)" = "$SLURM_CONF" ] && rm /etc/slurm/slurm.conf
exit 0
