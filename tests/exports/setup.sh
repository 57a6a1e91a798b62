#!/usr/bin/env bash
# Makes an environment for each program that reads our exports.  usage: setup.sh UV PYTHON FOLDER
# Their versions are fixed, and their dependencies are the lists beside this file: OpenQuake asks for
# versions that newer Pythons have no wheels of. What cannot be installed is told, and its tests skip.
set -uo pipefail
uv=$1 python=$2 folder=$3 here=$(dirname "$0")

for list in "$here"/*.txt; do
    name=$(basename "$list" .txt) venv=$folder/$(basename "$list" .txt)
    [ "$venv/.installed" -nt "$list" ] && continue
    if "$uv" venv --quiet --clear --python "$python" "$venv" &&
        VIRTUAL_ENV=$venv timeout 900 "$uv" pip install --quiet --no-deps --requirement "$list"; then
        touch "$venv/.installed"
    else
        echo "$name could not be installed: its tests are skipped" >&2
    fi
done
