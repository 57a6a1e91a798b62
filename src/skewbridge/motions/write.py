"""Write motions as PEER acceleration files with an index."""

import csv
import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.index import COLUMNS
from skewbridge.motions.read import files_digest
from skewbridge.motions.record import NUMBER_FIELDS, TEXT_FIELDS, GroundMotion, Vector
from skewbridge.provenance.files import writable_folder
from skewbridge.reading import no_formula
from skewbridge.units import G_MPS2

_PER_LINE: Final = 5
_FREE_TEXT: Final = frozenset({"event", "station", "source", "licence"})


def at2_text(motion: GroundMotion, component: int) -> str:
    """Return one component (1 or 2) as the text of a PEER file, in g with 8 digits."""
    azimuth_deg = (motion.azimuth_1_deg, motion.azimuth_2_deg)[component - 1]
    if not np.isfinite(azimuth_deg):
        azimuth_deg = (360.0, 90.0)[component - 1]
    header = (
        "SYNTHETIC MOTION IN THE FORMAT OF THE PEER NGA STRONG MOTION DATABASE\n"
        f"{motion.event.replace(',', ';')}, 1/1/2000, {motion.station}, {azimuth_deg:.0f}\n"
        "ACCELERATION TIME SERIES IN UNITS OF G\n"
        f"NPTS= {motion.npts:6d}, DT= {motion.dt_s:.6g} SEC\n"
    )
    return header + _rows(motion.components[component - 1] / G_MPS2)


def write_at2(motion: GroundMotion, folder: Path) -> tuple[Path, Path]:
    """Write both components as `<motion_id>_h1.AT2` and `_h2.AT2`; return their paths."""
    paths = tuple(folder / f"{motion.motion_id}_h{component}.AT2" for component in (1, 2))
    writable_folder(folder)
    for component, path in enumerate(paths, start=1):
        path.write_text(at2_text(motion, component), encoding="ascii", newline="\n")
    return paths[0], paths[1]


def index_row(motion: GroundMotion, files: Sequence[Path], folder: Path) -> dict[str, object]:
    """Return what the index of a folder says of a motion in two of its files, or in none."""
    places = {f"file_{n}": path.relative_to(folder) for n, path in enumerate(files, start=1)}
    return {
        **{name: getattr(motion, name) for name in (*TEXT_FIELDS, *NUMBER_FIELDS)},
        **{name: path.as_posix() for name, path in places.items()},
        "npts": motion.npts,
        "sha256": files_digest(*files) if files else motion.sha256,
    }


def as_files_digest(motion: GroundMotion) -> str:
    """Return the digest that the two files of `write_at2` would have, see `files_digest`."""
    text = "".join(at2_text(motion, component) for component in (1, 2))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def write_index(index: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write an `index.csv`; what a row has not is left empty, numbers get 8 digits.

    Columns that are not ours are kept, after ours.
    """
    columns = list(dict.fromkeys([*COLUMNS, *(name for row in rows for name in row)]))
    try:
        with index.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, columns, lineterminator="\n")
            writer.writeheader()
            for row in rows:
                writer.writerow({name: _cell(name, row.get(name, "")) for name in columns})
    except OSError as error:
        raise InputError(f"{index} can't be written: {error}", file=str(index)) from error


def _rows(accel_g: Vector) -> str:
    # Tiny numbers would need a three-digit exponent
    values = np.where(np.abs(accel_g) < 1.0e-20, 0.0, accel_g)
    cells = [f"{value:15.7E}" for value in values.tolist()]
    lines = ["".join(cells[i : i + _PER_LINE]) for i in range(0, len(cells), _PER_LINE)]
    return "\n".join(lines) + "\n"


def _cell(name: str, value: object) -> object:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.8g}"
    return no_formula(value) if name in _FREE_TEXT else value
