"""The prepared suite of a study as a table: what its analyses read."""

import json
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.motions.intensity import IM_COLUMNS, scaled_measures
from skewbridge.motions.record import NUMBER_FIELDS, TEXT_FIELDS, GroundMotion, SuiteMotion
from skewbridge.provenance.tables import provenance, read_frame, write_frame


def suite_row(motion: GroundMotion, scale: float, measures: dict[str, float]) -> dict[str, object]:
    """Return the row of a motion with its factor and its measures at factor 1."""
    return {
        "motion_id": motion.motion_id,
        "scale": scale,
        "npts": motion.npts,
        **{name: getattr(motion, name) for name in (*TEXT_FIELDS, *NUMBER_FIELDS)},
        **measures,
        "accel_1_mps2": motion.accel_1_mps2,
        "accel_2_mps2": motion.accel_2_mps2,
        "messages": json.dumps(list(motion.messages)),
    }


def write_suite(suite: pd.DataFrame, path: Path) -> None:
    """Write the table of `prepare_suite` as parquet."""
    write_frame(suite, path, provenance())


def read_suite(path: Path) -> list[SuiteMotion]:
    """Return the motions of a table written by `write_suite`, in suite order.

    Raises:
        InputError: No such table, or one of another version of the program.
    """
    motions: list[SuiteMotion] = []
    for row in read_frame(path).to_dict("records"):
        known: dict[str, Any] = {name: str(row[name]) for name in TEXT_FIELDS}
        known |= {name: float(row[name]) for name in NUMBER_FIELDS}
        motion = GroundMotion(
            **known,
            accel_1_mps2=row["accel_1_mps2"],
            accel_2_mps2=row["accel_2_mps2"],
            messages=tuple(json.loads(row["messages"])),
        )
        scale = float(row["scale"])
        measures = scaled_measures({name: float(row[name]) for name in IM_COLUMNS}, scale)
        motions.append(SuiteMotion(motion=motion, scale=scale, measures=measures))
    return motions
