#!/usr/bin/env bash
# Runs the benchmarks one after the other: ratios of two things in one run, never asserted.
# The programs compared with come into environments of their own, never into .venv.
set -euo pipefail
cd "$(dirname "$0")/.."
uv=$(command -v uv || echo .uv/bin/uv)
version=$(cat .python-version)
out=results/benchmarks
mkdir -p "$out"

# environment NAME REQUIREMENTS: an environment with the locked packages and those of a comparison
environment() {
    local folder=.bench/$1
    [ -x "$folder/bin/python" ] || "$uv" venv --quiet --python "$version" "$folder"
    VIRTUAL_ENV=$folder "$uv" pip install --quiet --requirement "$2" pandas pyarrow pydantic pyyaml
    echo "$folder/bin/python"
}

motions=$(environment motions benchmarks/requirements-motions.txt)
fragility=$(environment fragility benchmarks/requirements-fragility.txt)
export PYTHONPATH=src OMP_NUM_THREADS=1
pair=(motions/synthetic/syn002_h1.AT2 motions/synthetic/syn002_h2.AT2)

"$motions" -W ignore benchmarks/motions_spectra.py | tee "$out/motions.json"
"$fragility" -W ignore benchmarks/fragility_speed.py | tee "$out/fragility.json"
.venv/bin/python benchmarks/contact_update.py --out "$out"
.venv/bin/python benchmarks/analysis_overhead.py "${pair[@]}" | tee "$out/overhead.txt"
