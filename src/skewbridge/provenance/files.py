"""Atomic writing of files, and checks that folders can be written."""

import os
import socket
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from skewbridge.errors import InputError


@contextmanager
def written_aside(path: Path) -> Generator[Path]:
    """Yield a temporary path next to a file, and rename it to the file when it is complete.

    A reader, or a study that resumes after a kill, never sees an incomplete file.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{_writer()}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with written_aside(path) as part:
        part.write_text(text, encoding="utf-8")


def writable_folder(folder: Path) -> Path:
    """Return a folder in which files can be written, and create it if necessary.

    A file is written as a test, because access rights alone do not suffice (the superuser,
    read-only file systems, a file of that name).

    Raises:
        InputError: The folder cannot be created or written.
    """
    probe = folder / f".write-test-{_writer()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"cannot write to the folder {str(folder)!r}: {error.strerror}") from None
    return folder


def writable_file(path: Path) -> Path:
    """Return the path of a file that can be written, and create its folder if necessary.

    Raises:
        InputError: The folder cannot be made or written, or the path is a folder.
    """
    writable_folder(path.parent)
    if path.is_dir():
        raise InputError(f"cannot write the file {str(path)!r}: it is a folder")
    return path


def _writer() -> str:
    """Return process and host: two nodes of a cluster may have equal process numbers."""
    return f"{socket.gethostname()}.{os.getpid()}"
