#!/usr/bin/env bash
# Runs the study, one at a time in a folder.  usage: study.sh BIN CORES CONFIG [MOTIONS_FOLDER [TARGET [PROFILE]]]
set -euo pipefail
bin=$1 cores=$2 config=$3 motions=${4:-} target=${5:-all} profile=${6:-}

exec 9>.study.lock
flock --nonblock 9 || { echo "Another study is running in this folder." >&2; exit 1; }
# The lock above ends with its holders, so one that a killed workflow left behind is stale.
if compgen -G ".snakemake/locks/*" >/dev/null; then
    "$bin/snakemake" --unlock -j"$cores" --configfile "$config" >/dev/null
fi
override=()
[ -z "$motions" ] || override=(--config "motions={folder: \"$motions\"}")
# On a cluster the profile says how many jobs there may be at once; here it is the processors.
how=(-j"$cores")
[ -z "$profile" ] || how=(--workflow-profile "workflow/profiles/$profile")
"$bin/snakemake" "${how[@]}" --rerun-incomplete --show-failed-logs --configfile "$config" "${override[@]}" -- "$target"
