"""What the files of a suite say, as one digest: notes and times of the files do not count."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from skewbridge.provenance.digests import digest_of
from skewbridge.provenance.files import write_text

if TYPE_CHECKING:
    from skewbridge.motions.index import IndexEntry


def content_digest(
    folder: Path,
    count: int | None,
    *,
    t1_s: float,
    level_range_g: tuple[float, float],
    cache: Path,
) -> str:
    """Return the digest of the index entries and files that a suite (see `prepare_suite`) has.

    The files are read only if a name, a size or a time in the folder has changed since the digest
    was kept in the file `cache`.

    Raises:
        InputError: As `entries_to_read`, or a file that cannot be read.
    """
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    states = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in files]
    state = digest_of(str(folder.resolve()), count, t1_s, level_range_g, *states)
    kept = _kept(cache)
    if kept.get("state") == state:
        return kept["digest"]
    # Here, because every job of a study reads the Snakefile: loading the readers takes seconds.
    from skewbridge.motions.suite import entries_to_read

    entries, wanted = entries_to_read(folder, count, t1_s=t1_s, level_range_g=level_range_g)
    digest = digest_of(wanted, *(_said(entry, folder) for entry in entries))
    write_text(cache, json.dumps({"state": state, "digest": digest}))
    return digest


def _said(entry: "IndexEntry", folder: Path) -> tuple[object, ...]:
    """Return what the index and the files say of one motion; one that is made has no files."""
    from skewbridge.motions.read import files_digest

    files = [path for path, _ in entry.components]
    said = asdict(entry)
    if files:
        said |= {f"file_{n}": path.relative_to(folder) for n, path in enumerate(files, start=1)}
    return (*((name, str(value)) for name, value in said.items()), files_digest(*files))


def _kept(cache: Path) -> dict[str, str]:
    try:
        return json.loads(cache.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
