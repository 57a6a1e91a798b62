"""`skewbridge deck`: a case file in, the histories of the rigid skew deck out."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.errors import InputError, SolutionError
from skewbridge.motions.read import read_motion
from skewbridge.provenance.files import writable_file
from skewbridge.verification.references.case_files import DeckCase, beside, read_case
from skewbridge.verification.references.deck_lcp import run_lcp
from skewbridge.verification.references.deck_model import (
    CORNERS,
    DeckHistory,
    Excitation,
    make_deck,
    pulse_of,
)
from skewbridge.verification.references.deck_opensees import run_opensees
from skewbridge.verification.references.deck_penalty import run_penalty

_DESCRIPTIONS: Final = {
    "t_s": ("s", "time"),
    "ux_m": ("m", "displacement of the mass centre relative to the ground, along the deck"),
    "uy_m": ("m", "the same across the deck"),
    "theta_rad": ("rad", "rotation, counter-clockwise"),
    "gap": ("m", "opening, negative in contact"),
    "fn": ("N", "compression"),
    "ft": ("N", "friction force with the sign of slip"),
}


def run_deck(case: DeckCase, excitation: Excitation | None = None) -> DeckHistory:
    """Run a deck case with the solver that it names; its excitation is its pulse unless given.

    Raises:
        SolutionError: The solver could not finish.
    """
    solver = {"opensees": run_opensees, "penalty": run_penalty, "lcp": run_lcp}[case.solver]
    return solver(case, make_deck(case), excitation or pulse_of(case))


def run_deck_case(case_file: Path, out: Path) -> dict[str, Any]:
    """Run a deck case file and write its histories as parquet.

    Returns:
        Peaks, time of the first contact, energy residual.

    Raises:
        InputError: The case, a motion or the output folder is wrong.
        SolutionError: The solver could not finish.
    """
    case = read_case(case_file, DeckCase)
    excitation = _excitation(case, case_file)
    writable_file(out)
    history = run_deck(case, excitation)
    if not np.isfinite(history.q).all():
        raise SolutionError("the response is not finite: use a smaller dt_s")
    pq.write_table(_table(history), out)
    return {
        "peaks": history.peaks(),
        "first_contact_s": history.first_contact_s(),
        "energy_residual_ratio": history.energy_residual_ratio,
        "out": str(out),
    }


def _excitation(case: DeckCase, case_file: Path) -> Excitation:
    if case.motion is None:
        return pulse_of(case)
    first, second = (beside(case_file, name) for name in case.motion)
    for path in (first, second):
        if not path.exists():
            raise InputError(f"motion {path} does not exist")
    motion = read_motion(first, second)
    return Excitation(
        sample_dt_s=motion.dt_s, samples_mps2=np.array([motion.accel_1_mps2, motion.accel_2_mps2])
    )


def _table(history: DeckHistory) -> pa.Table:
    columns = {"t_s": history.t_s}
    columns |= dict(zip(("ux_m", "uy_m", "theta_rad"), history.q.T, strict=True))
    for prefix, unit, values in (
        ("gap", "m", history.openings_m),
        ("fn", "n", history.normals_n),
        ("ft", "n", history.tangentials_n),
    ):
        columns |= {f"{prefix}_{c}_{unit}": v for c, v in zip(CORNERS, values.T, strict=True)}
    fields: list[pa.Field[Any]] = []
    for name in columns:
        unit, text = _DESCRIPTIONS.get(name) or _DESCRIPTIONS[name[:3].rstrip("_")]
        fields.append(pa.field(name, pa.float64(), metadata={"unit": unit, "description": text}))
    return pa.table([pa.array(v) for v in columns.values()], schema=pa.schema(fields))
