#!/usr/bin/env bash
# Runs the benchmarks one after the other. They measure ratios; missed targets are not errors.
# Other programs are installed in separate environments, never in .venv.
#     benchmarks/run.sh          quick sets, about 20 minutes
#     FULL=1 benchmarks/run.sh   full sets, hours; finished cases of the longest part are kept
set -euo pipefail
cd "$(dirname "$0")/.."
uv=$(command -v uv || echo .uv/bin/uv)
version=$(cat .python-version)
out=results/benchmarks
mkdir -p "$out"

# environment NAME: an environment with the imports of the package and the other programs
environment() {
    local folder=.bench/$1
    [ -x "$folder/bin/python" ] || "$uv" venv --quiet --python "$version" "$folder"
    VIRTUAL_ENV=$folder "$uv" pip install --quiet --requirement "benchmarks/requirements-$1.txt" \
        joblib pandas pyarrow pydantic pyyaml 1>&2
    echo "$folder/bin/python"
}

# measure NAME PYTHON ARGUMENTS...: one entry, stored when it is complete
measure() {
    local name=$1 python=$2
    shift 2
    echo "$name ..." 1>&2
    rm -f "$out/$name.json"
    "$python" -W ignore "$@" > "$out/$name.part"
    mv "$out/$name.part" "$out/$name.json"
}

export PYTHONPATH=src OMP_NUM_THREADS=1
ours=.venv/bin/python
if [ -n "${FULL:-}" ]; then
    speedup=() workers=() pipeline=()
else
    speedup=(--quick)
    workers=(--analyses 4 --memory-analyses 60)
    pipeline=(--variants 1 --duration-s 10)
fi

measure speedup "$ours" benchmarks/speedup.py "${speedup[@]}"
measure overhead "$ours" benchmarks/overhead.py
measure native "$ours" benchmarks/native.py
measure workers "$ours" benchmarks/workers.py "${workers[@]}"
measure pipeline "$ours" benchmarks/pipeline.py "${pipeline[@]}"
measure contact_update "$ours" benchmarks/contact_update.py
measure motions "$(environment motions)" benchmarks/motions_spectra.py
measure fragility "$(environment fragility)" benchmarks/fragility_speed.py
"$ours" benchmarks/assemble.py
