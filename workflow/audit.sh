#!/usr/bin/env bash
# Looks the locked packages up among the known vulnerabilities; skipped without a network.  usage: audit.sh BIN
set -euo pipefail
bin=$1
if ! "$bin/python" -c "import urllib.request; urllib.request.urlopen('https://pypi.org/pypi/pip-audit/json', timeout=10).close()" 2>/dev/null; then
    echo "audit: skipped, because https://pypi.org cannot be reached from here" >&2
    exit 0
fi
uv=$(command -v uv || echo .uv/bin/uv)
[ -x .audit/bin/python ] || "$uv" venv --quiet --python "$bin/python" .audit
VIRTUAL_ENV=.audit "$uv" pip sync --quiet --require-hashes workflow/audit.txt
# The locks have a hash of every file: nothing is resolved or installed.
for lock in requirements.lock workflow/uv.txt workflow/audit.txt workflow/browser.txt; do
    echo "$lock" >&2
    .audit/bin/pip-audit --require-hashes --disable-pip --progress-spinner off --requirement "$lock"
done
