#!/usr/bin/env bash
# Starts a Slurm of two nodes on this host, without systemd and beside any Slurm that runs here.
# usage: start.sh FOLDER [CORES_PER_NODE [MEMORY_MB_PER_NODE]]
set -euo pipefail
folder=$(realpath -m "$1") cores=${2:-4} memory_mb=${3:-6000}
here=$(cd "$(dirname "$0")" && pwd)
host=$(hostname -s)

# The executor clears SLURM_CONF on the nodes, so the configuration lies where Slurm looks for it.
[ ! -e /etc/slurm/slurm.conf ] || { echo "start.sh: this host belongs to a cluster (/etc/slurm/slurm.conf)" >&2; exit 1; }
mkdir -p "$folder"/{state,spool.node1,spool.node2}
chmod 755 "$folder"
(umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
# Ports of this cluster alone, beside those of another one.
read -r controller first second < <(python3 -c '
import socket
held = [socket.socket() for _ in range(3)]
for each in held:
    each.bind(("127.0.0.1", 0))
print(*(each.getsockname()[1] for each in held))')
sed -e "s|@FOLDER@|$folder|; s|@HOST@|$host|; s|@CORES@|$cores|; s|@MEMORY_MB@|$memory_mb|" \
    -e "s|@CONTROLLER@|$controller|; s|@FIRST@|$first|; s|@SECOND@|$second|" \
    "$here/slurm.conf.in" >"$folder/slurm.conf"
mkdir -p /etc/slurm && ln -sfn "$folder/slurm.conf" /etc/slurm/slurm.conf

munged --force --socket="$folder/munge.socket" --key-file="$folder/munge.key" --pid-file="$folder/munged.pid" \
    --log-file="$folder/munged.log" --seed-file="$folder/munge.seed"
slurmctld -i
for node in node1 node2; do
    slurmd -N "$node"
done
# Up when both nodes have registered.
for _ in $(seq 60); do
    [ "$(sinfo --noheader --Node --states=idle --format=%N 2>/dev/null | wc -l)" = 2 ] && exit 0
    sleep 0.5
done
echo "start.sh: the nodes did not register:" >&2
tail -n 20 "$folder"/*.log >&2
exit 1
