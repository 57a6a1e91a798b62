"""Write the licences of the locked packages as a page: `python workflow/licences.py LOCK`."""

import re
import sys
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

from skewbridge.files.digests import licence_of

HEAD = """\
# Licences

Packages that `make setup` installs (versions: `requirements.lock`), by the licence in their
metadata. skewbridge itself is BSD-3-Clause (`LICENSE`). The licence of OpenSeesPy is in its package
(`LICENSE.md`). `make docs` writes this page.

| licence | packages |
|---|---|
"""


def rows_of(lock: Path) -> list[str]:
    """Return a row for each licence of the packages of a lock that are installed."""
    packages: dict[str, list[str]] = {}
    for name in re.findall(r"^([\w.-]+)==", lock.read_text(encoding="utf-8"), re.M):
        try:
            licence = licence_of(metadata(name))
        except PackageNotFoundError:
            licence = "not installed on this platform"
        packages.setdefault(licence.replace("|", "/"), []).append(name)
    return [f"| {licence} | {', '.join(names)} |\n" for licence, names in sorted(packages.items())]


if __name__ == "__main__":
    sys.stdout.write(HEAD + "".join(rows_of(Path(sys.argv[1]))))
