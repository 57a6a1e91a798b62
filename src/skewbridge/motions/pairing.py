"""Pairs of component files of one motion, by file name or header."""

import math
import re
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Final, NoReturn

from skewbridge.errors import InputError
from skewbridge.motions.trace import Trace

# Vertical components (UP, DWN, V) are never used: the bridge gets two horizontal ones.
_VERTICAL = re.compile(r"[-_.](UP|UD|DWN|DN|V|VER|VERT|Z|H?3)$|[a-z0-9](DWN|-UP)$", re.IGNORECASE)

_NIED = re.compile(r"\.(?P<end>EW|NS|UD)(?P<sensor>[12]?)", re.IGNORECASE)

AZIMUTH_TOLERANCE_DEG: Final = 2.0

# Endings that distinguish the components of one motion, the most specific first.
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
    """Return whether a file name is that of a vertical component."""
    return path.suffix.lower().startswith(".ud") or bool(_VERTICAL.search(path.stem))


def motion_name(first: Path, second: Path) -> str:
    """Return the name of a motion: what both file names share, else the first name."""
    name, _ = split_name(first)
    return name if split_name(second)[0] == name else first.stem


def group_by_name(paths: Iterable[Path]) -> dict[str, list[Path]]:
    """Return the horizontal component files of each motion name, both sorted.

    If files of the same name form a pair in each of several folders, these are different motions:
    their names start with the name of the folder if these names differ.
    """
    groups: defaultdict[str, defaultdict[Path, list[Path]]] = defaultdict(lambda: defaultdict(list))
    for path in sorted(paths):
        if not is_vertical(path):
            groups[split_name(path)[0]][path.parent].append(path)
    named: dict[str, list[Path]] = {}
    for name, folders in groups.items():
        apart = len({folder.name for folder in folders}) == len(folders) > 1
        if apart and all(len(files) == 2 for files in folders.values()):
            named |= {f"{folder.name}_{name}": files for folder, files in folders.items()}
        else:
            named[name] = [path for files in folders.values() for path in files]
    return dict(sorted(named.items()))


def refuse_unpaired(name: str, files: list[Path]) -> NoReturn:
    """Raise the error for a motion that does not have two files.

    Raises:
        InputError: Always.
    """
    listed = ", ".join(path.name for path in files)
    raise InputError(
        f"motion {name}: {len(files)} component file(s) found ({listed}), 2 needed; "
        "name the pairs in an index.csv",
        files=[path.name for path in files],
    )


def pair_by_header(traces: Iterable[Trace]) -> dict[str, tuple[Trace, Trace]]:
    """Return the pairs by station, event and azimuth of the headers.

    Two horizontal components of one station and event, 90 degrees apart, are a pair; a file
    without an azimuth (the vertical one) is left out.
    """
    groups: defaultdict[tuple[str, str], list[Trace]] = defaultdict(list)
    for trace in traces:
        if trace.station and math.isfinite(trace.azimuth_deg):
            groups[trace.event, trace.station].append(trace)
    pairs: dict[str, tuple[Trace, Trace]] = {}
    for (event, station), found in groups.items():
        if len(found) != 2:
            continue
        first, second = sorted(found, key=lambda trace: trace.path.name)
        apart_deg = (first.azimuth_deg - second.azimuth_deg) % 180.0
        if abs(apart_deg - 90.0) <= AZIMUTH_TOLERANCE_DEG:
            name = re.sub(r"[^A-Za-z0-9]+", "_", f"{station}_{event}").strip("_")
            pairs[name] = (first, second)
    return pairs


def pairs_among(traces: list[Trace], *, given_as_pair: bool = False) -> list[tuple[Trace, Trace]]:
    """Return the pairs among some components: by name, else by header.

    A second component (`_h2`) without a first of the same name is paired with the `_h1` before it.
    Two components given as a pair are always a pair.
    """
    if given_as_pair and len(traces) == 2:
        first, second = sorted(traces, key=lambda trace: trace.path)
        return [(first, second)]
    groups: defaultdict[tuple[Path, str], list[Trace]] = defaultdict(list)
    horizontal = [trace for trace in traces if not is_vertical(trace.path)]
    for trace in horizontal:
        groups[trace.path.parent, split_name(trace.path)[0]].append(trace)
    found = [(group[0], group[1]) for group in groups.values() if len(group) == 2]
    paired = {trace.path for pair in found for trace in pair}
    left = [trace for trace in horizontal if trace.path not in paired]
    found += pair_by_header(left).values()
    paired |= {trace.path for pair in found for trace in pair}
    last_first: Trace | None = None
    for trace in horizontal:
        ending = split_name(trace.path)[1]
        if ending == "h1":
            last_first = trace
        elif ending == "h2" and trace.path not in paired and last_first is not None:
            found.append((last_first, trace))
    return found
