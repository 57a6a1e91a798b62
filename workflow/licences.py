"""Write the licences of the locked packages as a page: `python workflow/licences.py LOCK`."""

import re
import sys
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

from skewbridge.provenance.licences import licence_of

HEAD = """\
# Licences

What `make setup` installs, with the licence that each package states in its metadata. skewbridge
itself is BSD-3-Clause (`LICENSE`). The licence of OpenSeesPy stands in its package (`LICENSE.md`).

This page is written by `make docs`.

| package | version | licence |
| --- | --- | --- |
"""


def rows_of(lock: Path) -> list[str]:
    """Return a row for each package of a lock that is installed."""
    rows: list[str] = []
    for name, version in re.findall(r"^([\w.-]+)==(\S+)", lock.read_text(encoding="utf-8"), re.M):
        try:
            licence = licence_of(metadata(name))
        except PackageNotFoundError:
            licence = "not installed on this platform"
        rows.append(f"| {name} | {version} | {licence.replace('|', '/')} |\n")
    return rows


if __name__ == "__main__":
    sys.stdout.write(HEAD + "".join(rows_of(Path(sys.argv[1]))))
