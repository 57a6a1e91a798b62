"""Write the licences of the locked packages as a page: `python workflow/licences.py LOCK`."""

import re
import sys
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from pathlib import Path

HEAD = """\
# Licences

What `make setup` installs, with the licence that each package states in its metadata. skewbridge
itself is BSD-3-Clause (`LICENSE`). The licence of OpenSeesPy stands in its package (`LICENSE.md`).

This page is written by `make docs`.

| package | version | licence |
| --- | --- | --- |
"""
LONGEST = 80


def licence_of(found: PackageMetadata) -> str:
    """Return the licence of a package: its expression, else its classifiers, else its text."""
    classified = [
        text.rpartition(" :: ")[2]
        for text in found.get_all("Classifier") or []
        if text.startswith("License :: ") and text != "License :: OSI Approved"
    ]
    stated = (found.get("License") or "").strip().split("\n")[0]
    return (
        found.get("License-Expression") or ", ".join(classified) or stated[:LONGEST] or "not stated"
    )


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
