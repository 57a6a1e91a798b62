"""Digest of the motions of a suite; other files of the folder and times do not count."""

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from skewbridge.errors import InputError
from skewbridge.files.digests import digest_of, layer_digest
from skewbridge.files.text import read_json, shown_path, write_text
from skewbridge.motions.index import files_below

if TYPE_CHECKING:
    from skewbridge.motions.index import IndexEntry


def content_digest(
    folder: Path,
    count: int | None,
    *,
    t1_s: float,
    level_range_g: tuple[float, float],
    cache: Path | None,
) -> str:
    """Return the digest of the index entries and files that a suite (see `prepare_suite`) has.

    The motions are read, and refused where they are wrong, only if a name, a size or a time in the
    folder, or a reader, has changed since the digest was kept in the file `cache`, if there is one.

    Raises:
        InputError: As `entries_to_read`, or motions that cannot be read; names each of them.
    """
    states = [_state_of(path) for path in files_below(folder)]
    readers = layer_digest(("errors.py", "units.py", "files", "motions"))
    state = digest_of(str(folder.resolve()), count, t1_s, level_range_g, readers, *states)
    kept = {} if cache is None else _kept(cache)
    if kept.get("state") == state:
        return kept["digest"]
    # Here, because every job of a study reads the Snakefile: loading the readers takes seconds.
    from skewbridge.motions.suite import entries_to_read, read_entries

    entries, wanted = entries_to_read(folder, count, t1_s=t1_s, level_range_g=level_range_g)
    read_entries([entry for entry in entries if entry.components])  # not the generated ones
    digest = digest_of(wanted, *(_values_of(entry, folder) for entry in entries))
    if cache is not None:
        write_text(cache, json.dumps({"state": state, "digest": digest}))
    return digest


def _state_of(path: Path) -> tuple[str, int, int]:
    """Return name, size and time of a file.

    Raises:
        InputError: It was removed since the folder was listed.
    """
    try:
        state = path.stat()
    except OSError as error:
        message = f"{shown_path(path)} cannot be read: {error.strerror}"
        raise InputError(message, file=str(path)) from None
    return str(path), state.st_size, state.st_mtime_ns


def _values_of(entry: "IndexEntry", folder: Path) -> tuple[object, ...]:
    """Return the values of the index and the digest of the files of one motion."""
    from skewbridge.motions.read import files_digest

    files = [(path.relative_to(folder), given) for path, given in entry.components]
    values = asdict(replace(entry, components=())) | {"components": files}
    digest = files_digest(*(path for path, _ in entry.components))
    return (*((name, str(value)) for name, value in values.items()), digest)


def _kept(cache: Path) -> dict[str, str]:
    try:
        kept = read_json(cache)
    except InputError:
        return {}
    return kept if isinstance(kept, dict) and {"state", "digest"} <= kept.keys() else {}
