#!/usr/bin/env bash
# Runs the study.  usage: study.sh BIN CORES CONFIG [MOTIONS_FOLDER [TARGET [RETRY]]]
set -euo pipefail
bin=$1 cores=$2 config=$3 motions=${4:-} target=${5:-all} retry=${6:-}

[ -z "$retry" ] || "$bin/skewbridge" retry --status "$retry" --config "$config"
override=()
[ -z "$motions" ] || override=(--config "motions={folder: \"$motions\"}")
exec "$bin/snakemake" -j"$cores" --show-failed-logs --configfile "$config" "${override[@]}" -- "$target"
