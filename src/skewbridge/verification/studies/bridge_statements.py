"""What the paper states of the straight bridge of figures 11 and 12, judged by a pair of runs."""

from typing import Final

import numpy as np

from skewbridge.analysis.result import AnalysisResult
from skewbridge.verification.judgement import (
    Judgement,
    at_least,
    at_most,
    cannot_be_told,
    decided,
    grows_with,
    lower,
    more_often,
    reduced_by,
)
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies.abutment_statements import FEWEST_CHANGES
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    FRICTION_PCT,
    histories_of,
    stick_slip_changes,
)
from skewbridge.verification.studies.half_cycles import HalfCycle, half_cycles
from skewbridge.verification.studies.paper_motions import PaperMotion

type Pair = tuple[AnalysisResult, AnalysisResult]
"""With friction, without."""

# source: the paper, section 5: 2 to 3 %, as rounded to whole percents
_PAPER_REDUCTION: Final = (0.015, 0.035)
# ASSUME a history that changes by more than the largest error of the default time step is coupled.
_COUPLED: Final = 0.02
_DISPLACEMENTS: Final = {
    "resultant": "deck_disp_m",
    "longitudinal": "deck_disp_x_m",
    "transverse": "deck_disp_y_m",
}
_AXES: Final = {"longitudinal": "x", "transverse": "y"}
_SIDES: Final = ("left", "right")


def judge_bridge(study: Study, case: str, pair: Pair, motion: PaperMotion) -> None:
    """Judge the straight bridge with friction against the one without."""
    case += motion.stand_in
    for axis, column in _AXES.items():
        cycles = _cycles(pair, column)
        study.states("bridge cycles", f"{case}, {axis}", _lower_in_contact(cycles))
    for axis, column in _AXES.items():
        change = history_change(pair, f"deck_u{column}_m")
        text = f"RMS change of the {axis} displacement over its RMS"
        study.states("axes are coupled", f"{case}, {axis}", at_least(text, change, _COUPLED))
    _judge_peaks(study, case, pair, same_record=motion.is_paper_record)
    for side in _SIDES:
        along, across = (history_change(pair, f"abutment_{side}_{axis}_kn") for axis in ("x", "y"))
        reason = f"RMS change of the force {across:.1%} transverse, {along:.1%} longitudinal"
        judged = decided(across > along, reason, across, along)
        study.states("bridge transverse loops", f"{case}, {side} abutment", judged)
    changes = _key_changes(pair[0])
    study.states("keys stick and slip", case, at_least("changes", changes, FEWEST_CHANGES))
    for axis, column in _AXES.items():
        cycles = _cycles(pair, column)
        judged = grows_with(
            "size of the change against how much both peaks coincide",
            [cycle.together for cycle in cycles],
            [abs(cycle.peak_with_m - cycle.peak_without_m) for cycle in cycles],
        )
        study.states("in phase differs most", f"{case}, {axis}", judged)


def transverse_cycles(pair: Pair) -> list[HalfCycle]:
    """Return the transverse half cycles of the deck."""
    return _cycles(pair, "y")


def _judge_peaks(study: Study, case: str, pair: Pair, *, same_record: bool) -> None:
    """Judge the peak displacements and the column shear."""
    with_friction, without = (result.whole_history for result in pair)
    for name, demand in _DISPLACEMENTS.items():
        peaks = with_friction[demand], without[demand]
        judged = lower(f"peak displacement, {name},", *peaks)
        study.states("displacement is reduced", f"{case}, {name}", judged)
        judged = reduced_by(f"{name} peak", *peaks, _PAPER_REDUCTION, same_record=same_record)
        study.states("displacement by 2 to 3 percent", f"{case}, {name}", judged)
    shears = with_friction["column_shear_kn"], without["column_shear_kn"]
    study.states("shear is reduced", case, lower("peak column shear", *shears))
    reductions = [
        1.0 - with_friction[demand] / without[demand]
        for demand in ("column_shear_kn", "deck_disp_m")
    ]
    text = (
        f"reduction of the shear {reductions[0]:.1%}, of the displacement {reductions[1]:.1%}; "
        "difference"
    )
    judged = at_most(text, abs(reductions[0] - reductions[1]), _PAPER_REDUCTION[0])
    study.states("shear by as much", case, judged)


def _cycles(pair: Pair, axis: str) -> list[HalfCycle]:
    """Return the half cycles of the deck along an axis."""
    friction, plain = (histories_of(result) for result in pair)
    count = min(len(friction["t_s"]), len(plain["t_s"]))
    walls = [f"abutment_{side}_wall_kn" for side in _SIDES]
    in_contact = np.logical_or.reduce(
        [table[wall][:count] > 0.0 for table in (friction, plain) for wall in walls]
    )
    own, other = f"deck_u{axis}_m", "deck_ux_m" if axis == "y" else "deck_uy_m"
    return half_cycles(
        plain["t_s"][:count],
        plain[own][:count],
        friction[own][:count],
        plain[other][:count],
        in_contact,
    )


def _lower_in_contact(cycles: list[HalfCycle]) -> Judgement:
    closed = [cycle for cycle in cycles if cycle.has_contact]
    if not closed:
        return cannot_be_told("the backwalls stay open")
    reduced = sum(cycle.change < 0.0 for cycle in closed)
    return more_often("peaks lower, half cycles in contact", reduced, len(closed))


def history_change(pair: Pair, column: str) -> float:
    """Return the RMS change of a history by friction over its RMS without."""
    friction, plain = (histories_of(result)[column] for result in pair)
    count = min(len(friction), len(plain))
    change = friction[:count] - plain[:count]
    return float(np.sqrt(np.mean(change**2) / np.mean(plain[:count] ** 2)))


def _key_changes(result: AnalysisResult) -> int:
    """Return how often the keys go from sticking to slipping or back."""
    table = histories_of(result)
    keys = [name for name in table if "key" in name and name.endswith("_normal_kn")]

    def column(name: str, part: str) -> Array:
        return table[name.replace("normal", part)]

    normals = np.column_stack([table[name] for name in keys])
    frictions = np.column_stack(
        [np.hypot(column(name, "friction_1"), column(name, "friction_2")) for name in keys]
    )
    return stick_slip_changes(normals, frictions, FRICTION_PCT / 100)
