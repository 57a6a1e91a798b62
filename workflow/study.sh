#!/usr/bin/env bash
# Runs the study.  usage: study.sh BIN CORES CONFIG [MOTIONS_FOLDER [TARGET [RETRY [PROFILE [UNTIL]]]]]
set -euo pipefail
bin=$1 cores=$2 config=$3 motions=${4:-} target=${5:-all} retry=${6:-} profile=${7:-} until=${8:-}

[ -f "$config" ] || { echo "study: there is no configuration $config" >&2 && exit 1; }
[ -z "$retry" ] || "$bin/skewbridge" study retry --status "$retry" --study "$config"
override=()
[ -z "$motions" ] || override+=("motions={folder: \"$motions\"}")
[ -z "${UNCERTAINTY:-}" ] || override+=("uncertainty={enabled: $UNCERTAINTY}")
[ -z "$until" ] || override+=("design={until: \"$until\"}")
[ ${#override[@]} = 0 ] || override=(--config "${override[@]}")
# On a cluster the profile limits the number of jobs; on this machine CORES does.
how=(-j"$cores")
[ -z "$profile" ] || how=(--workflow-profile "workflow/profiles/$profile")
# the reasons for running a rule are long and not shown; snakemake -n shows them
run() {
    "$bin/snakemake" "${how[@]}" --quiet host reason rules --show-failed-logs --configfile "$config" "${override[@]}" "$@"
}
run -- "$target"
# If the page exists, remake it so that it shows the table made on request.
if [ "$target" != all ]; then
    report=$("$bin/python" -c "import sys, pathlib
from skewbridge.study.config import load_config
print(load_config(pathlib.Path(sys.argv[1]), base=pathlib.Path('config/config.yaml')).results)" "$config")/report.html
    [ ! -f "$report" ] || run --forcerun figures report -- all
fi
