"""Files that are written whole or not at all, into folders that can be written."""

import os
import socket
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from skewbridge.errors import InputError


@contextmanager
def written_aside(path: Path) -> Generator[Path]:
    """Give a temporary path beside a file, and rename it to the file once all is written.

    A reader, or a study that goes on after a kill, never sees a file that is half there.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{_writer()}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    with written_aside(path) as part:
        part.write_text(text, encoding="utf-8")


def writable_folder(folder: Path) -> Path:
    """Return a folder, made if need be, into which files can be written.

    The write is tried, because access rights alone say too little (the superuser, read-only file
    systems, a file of that name).

    Raises:
        InputError: It cannot be made or written.
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
    """Return the path of a file that can be written, its folder made if need be.

    Raises:
        InputError: The folder cannot be made or written, or the path is a folder.
    """
    writable_folder(path.parent)
    if path.is_dir():
        raise InputError(f"cannot write the file {str(path)!r}: it is a folder")
    return path


def _writer() -> str:
    """Who writes: process and host, since two nodes of a cluster have equal process numbers."""
    return f"{socket.gethostname()}.{os.getpid()}"
