#!/usr/bin/env bash
# Runs the study.  usage: study.sh BIN CORES CONFIG [MOTIONS_FOLDER [TARGET [RETRY [PROFILE]]]]
set -euo pipefail
bin=$1 cores=$2 config=$3 motions=${4:-} target=${5:-all} retry=${6:-} profile=${7:-}

[ -f "$config" ] || { echo "study: there is no configuration $config" >&2 && exit 1; }
[ -z "$retry" ] || "$bin/skewbridge" study retry --status "$retry" --config "$config"
override=()
[ -z "$motions" ] || override=(--config "motions={folder: \"$motions\"}")
# On a cluster the profile says how many jobs there may be at once; here it is the processors.
how=(-j"$cores")
[ -z "$profile" ] || how=(--workflow-profile "workflow/profiles/$profile")
# why a rule runs is long; snakemake -n tells it
exec "$bin/snakemake" "${how[@]}" --quiet host reason --show-failed-logs --configfile "$config" "${override[@]}" -- "$target"
