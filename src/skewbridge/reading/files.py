"""Bytes and text of a file that somebody else wrote, up to a limit of its size."""

from pathlib import Path
from stat import S_ISREG
from typing import Final

from skewbridge.errors import InputError

LONGEST_SHOWN: Final = 80  # characters of a value in a message
LONGEST_PATH: Final = 200


def shortened(value: object) -> str:
    """Return a value as a message shows it: on one line, without control characters, not long."""
    text = repr(value)
    shown = text if len(text) <= LONGEST_SHOWN else f"{text[: LONGEST_SHOWN - 3]}..."
    return "".join(sign if sign.isprintable() else "?" for sign in shown)


def shown_path(path: Path) -> str:
    """Return a path as a message shows it; of a long one the end, which names the file."""
    text = "".join(sign if sign.isprintable() else "?" for sign in str(path))
    return text if len(text) <= LONGEST_PATH else f"...{text[3 - LONGEST_PATH :]}"


def read_bytes(path: Path, most: int) -> bytes:
    """Return the content of a file of at most so many bytes.

    Raises:
        InputError: There is no such file, it is a folder or a device, or it is larger.
    """
    shown = shown_path(path)
    try:
        state = path.stat()
        if not S_ISREG(state.st_mode):
            raise InputError(f"{shown}: a file is needed, not a folder or device", file=str(path))
        if state.st_size > most:
            raise InputError(
                f"{shown}: has {state.st_size} bytes, at most {most} are read", file=str(path)
            )
        with path.open("rb") as stream:
            content = stream.read(state.st_size + 1)
    except (OSError, ValueError) as error:  # a path with a zero byte is a ValueError
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown} cannot be read: {reason}", file=str(path)) from None
    if len(content) > state.st_size:
        raise InputError(f"{shown}: is being written to", file=str(path))
    return content


def read_text(path: Path, most: int) -> str:
    """Return the UTF-8 text of a file of at most so many bytes, without a byte order mark.

    Raises:
        InputError: As `read_bytes`, or a byte that is no UTF-8; names its line.
    """
    content = read_bytes(path, most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{shown_path(path)}, line {line}: byte 0x{content[error.start]:02x} is no UTF-8 text: "
            "save the file as UTF-8",
            file=str(path),
            line=line,
        ) from None
