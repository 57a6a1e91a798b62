"""Which files are the two components of one motion, from their names alone."""

import re
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError

# Vertical components (UP, DWN, V) are never used: the bridge gets two horizontal ones.
_VERTICAL = re.compile(r"[-_.](UP|UD|DWN|DN|V|VER|VERT|Z|H?3)$|[a-z0-9](DWN|-UP)$", re.IGNORECASE)

_NIED = re.compile(r"\.(?P<end>EW|NS|UD)(?P<sensor>[12]?)", re.IGNORECASE)

# Endings that tell the components of one motion apart, the most telling first.
_ENDINGS: Final = (
    re.compile(r"(?<=[A-Za-z_.\-])(?P<end>[0-3]\d{2})$"),  # azimuth: TAR090, E06140
    re.compile(r"(?<=[A-Za-z]\d)(?P<end>[0-3]\d{2})$"),
    re.compile(r"(?<=[A-Za-z]\d{2})(?P<end>[0-3]\d{2})$"),
    re.compile(r"(?<=[A-Za-z]\d{3})(?P<end>[0-3]\d{2})$"),
    re.compile(r"[-_.](?P<end>H?[12NEXY]|EW|NS|FN|FP)$", re.IGNORECASE),
    re.compile(r"(?<=\d)(?P<end>[12])$"),  # FEMA P-695: 120111, 120112
)


def split_name(path: Path) -> tuple[str, str]:
    """Return the name of the motion and the component ending of a file; ('name', '') if none."""
    if match := _NIED.fullmatch(path.suffix):  # K-NET and KiK-net name the component there
        sensor = {"1": "_borehole", "2": "_surface"}.get(match["sensor"], "")
        return path.stem + sensor, match["end"].lower()
    stem = path.stem
    for pattern in _ENDINGS:
        if match := pattern.search(stem):
            return stem[: match.start("end")].rstrip("-_. "), match["end"].lower()
    return stem, ""


def is_vertical(path: Path) -> bool:
    """Say whether the name is that of a vertical component."""
    return path.suffix.lower().startswith(".ud") or bool(_VERTICAL.search(path.stem))


def motion_name(first: Path, second: Path) -> str:
    """Return a name for the motion of two files: what their names share, else the first name."""
    name, _ = split_name(first)
    return name if split_name(second)[0] == name else first.stem


def pair_by_name(paths: Iterable[Path]) -> dict[str, tuple[Path, Path]]:
    """Return the two component files of each motion, keyed and sorted by the motion's name.

    The component whose file name sorts first is component 1. Vertical components are left out.

    Raises:
        InputError: A file without a partner, or more than two files of one name.
    """
    groups: defaultdict[str, list[Path]] = defaultdict(list)
    for path in sorted(paths):
        if not is_vertical(path):
            groups[split_name(path)[0]].append(path)
    pairs: dict[str, tuple[Path, Path]] = {}
    for name in sorted(groups):
        files = groups[name]
        if len(files) != 2:
            listed = ", ".join(path.name for path in files)
            msg = (
                f"motion {name}: {len(files)} component file(s) found ({listed}), 2 needed; "
                "name the pairs in an index.csv"
            )
            raise InputError(
                msg,
                files=[path.name for path in files],
            )
        pairs[name] = (files[0], files[1])
    return pairs
