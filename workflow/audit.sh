#!/usr/bin/env bash
# Checks the locked packages for known vulnerabilities; skipped if the database cannot be reached.  usage: audit.sh BIN
set -euo pipefail
bin=$1
# Advisories are on the page of each package version, which not every mirror has.
first=$(grep -m1 -oE '^[A-Za-z0-9_.-]+==[^ ]+' requirements.lock)
page="https://pypi.org/pypi/${first/==//}/json"
if ! "$bin/python" -c "import urllib.request; urllib.request.urlopen('$page', timeout=10).close()" 2>/dev/null; then
    echo "audit: skipped, because $page cannot be read from here" >&2
    exit 0
fi
uv=$(command -v uv || echo .uv/bin/uv)
[ -x .audit/bin/python ] || "$uv" venv --quiet --python "$bin/python" .audit
VIRTUAL_ENV=.audit "$uv" pip sync --quiet --require-hashes workflow/audit.txt
# The locks have hashes of all files: nothing is resolved or installed. A package without a page is an error.
for lock in requirements.lock workflow/uv.txt workflow/audit.txt workflow/browser.txt workflow/recorded.txt; do
    echo "$lock" >&2
    .audit/bin/pip-audit --strict --require-hashes --disable-pip --progress-spinner off --requirement "$lock"
done
