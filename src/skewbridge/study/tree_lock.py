"""One study at a time in a tree: a lock of the kernel, which ends with the process that holds it.

Snakemake's own locks are files that a killed run leaves behind, and nothing in them tells whether
the run is alive. This lock does, so that with it stale files can be removed without asking.
"""

import fcntl
import os
from contextlib import suppress
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError

LOCK_NAME: Final = "study.lock"


def hold_tree(folder: Path) -> None:
    """Take the lock of a tree for the rest of this process, and remove stale ones of Snakemake.

    Args:
        folder: ``.snakemake`` of the tree.

    Raises:
        InputError: Another study runs there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # Not closed: the lock ends with the process. No child inherits it.
    descriptor = os.open(folder / LOCK_NAME, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.read(descriptor, 32).decode(errors="replace").strip()
        os.close(descriptor)
        raise InputError(
            f"another study is running in {folder.parent.resolve()} (process {holder}): wait for "
            "it or end it, then give the same command again"
        ) from None
    with suppress(OSError):  # the number is only said; a full disk need not have it
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, str(os.getpid()).encode(), 0)
    for stale in (folder / "locks").glob("*.lock"):
        stale.unlink(missing_ok=True)
