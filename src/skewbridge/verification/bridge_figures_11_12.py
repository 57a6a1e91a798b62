"""Figures 11 and 12 of the paper: OSB1 without skew, with and without friction, and its statements.

The paper's record is WAHO; whatever stands in for it is named on the figures.
"""

from typing import Final

import numpy as np
import pandas as pd

from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings, Scheme
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.bridge_cycles import (
    HalfCycle,
    half_cycles,
    stick_slip_changes,
    together_correlation,
)
from skewbridge.verification.bridge_history_figures import (
    Pair,
    cycle_figure,
    displacement_figure,
    histories_of,
    hysteresis_figure,
)
from skewbridge.verification.bridge_records import PaperMotion, waho
from skewbridge.verification.checks import Checklist, StudyResult

FRICTION_PCT: Final = 50  # source: the paper, section 4
GAP_MM: Final = 51  # source: the paper, section 4
DURATION_S: Final = 25.0
FEW_PERCENT: Final = 0.05  # source: the paper gives 2-3 % for its record; others vary
_PAPER: Final = "paper, section 5"
_DEMANDS: Final = (
    "deck_disp_x_m",
    "deck_disp_y_m",
    "deck_disp_m",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)


def run() -> StudyResult:
    """Run the study."""
    motion = waho()
    checks = Checklist("fig11-12")
    pair = friction_pair(motion, "default")
    report_ratios(checks, "default scheme", pair)
    report_ratios(checks, "paper scheme", friction_pair(motion, "paper"))
    cycles = _cycles(pair)
    _peak_statements(checks, pair)
    _contact_statements(checks, pair, cycles)
    return StudyResult(
        checks=checks.checks,
        figures={
            "displacements": displacement_figure(pair, motion),
            "hysteresis": hysteresis_figure(pair, motion),
            "cycles": cycle_figure(cycles, motion),
        },
        tables={"cycles": pd.DataFrame([_row(cycle) for cycle in cycles])},
    )


def friction_pair(motion: PaperMotion, scheme: Scheme, skew_deg: int = 0) -> Pair:
    """Return the analyses of OSB1 with and without friction."""
    with_friction, without = (
        analyse(
            Variant(
                bridge="osb1",
                abutment="contact_friction",
                skew_deg=skew_deg,
                gap_mm=GAP_MM,
                friction_pct=friction,
            ),
            motion.motion,
            1.0,
            0.0,
            AnalysisSettings(scheme=scheme, duration_s=DURATION_S),
            ModelOptions(),
            histories=True,
        )
        for friction in (FRICTION_PCT, 0)
    )
    return with_friction, without


def report_ratios(checks: Checklist, name: str, pair: Pair) -> None:
    """Put the demands with friction beside those without."""
    for demand in _DEMANDS:
        checks.report(
            f"{name}: {demand}, friction 0.5 against 0",
            *(pair[0].demands[demand], pair[1].demands[demand], _PAPER),
        )
    slip = pair[0].demands["slip_work_kj"]
    checks.report(f"{name}: slip_work_kj", slip, 0.0, _PAPER)


def _cycles(pair: Pair) -> list[HalfCycle]:
    """Return the transverse half cycles."""
    friction, plain = (histories_of(result) for result in pair)
    count = min(len(friction["t_s"]), len(plain["t_s"]))
    walls = ("abutment_left_wall_kn", "abutment_right_wall_kn")
    in_contact = np.logical_or.reduce(
        [table[wall][:count] > 0.0 for table in (friction, plain) for wall in walls]
    )
    return half_cycles(
        plain["t_s"][:count],
        plain["deck_uy_m"][:count],
        friction["deck_uy_m"][:count],
        plain["deck_ux_m"][:count],
        in_contact,
    )


def _peak_statements(checks: Checklist, pair: Pair) -> None:
    """Check what the paper says about the peaks of the straight bridge."""
    with_friction, without = (result.demands for result in pair)
    checks.holds(
        "both analyses end with status ok and without a failed step",
        truth=all(result.status == "ok" and result.failed_attempts == 0 for result in pair),
        source="this model",
    )
    checks.holds(
        "the backwalls close",
        truth=min(with_friction["backwall_force_kn"], without["backwall_force_kn"]) > 0.0,
        source="this motion",
    )
    for demand in ("deck_disp_x_m", "deck_disp_m", "column_shear_kn"):
        checks.relative(
            f"{demand} changes by a few percent",
            *(with_friction[demand], without[demand], FEW_PERCENT, _PAPER),
        )
    checks.holds(
        "the transverse peak is lower with friction",
        truth=with_friction["deck_disp_y_m"] < without["deck_disp_y_m"],
        source=_PAPER,
    )
    changes = _key_changes(pair[0])
    checks.holds(f"the keys stick and slip ({changes} changes)", truth=changes >= 10, source=_PAPER)


def _contact_statements(checks: Checklist, pair: Pair, cycles: list[HalfCycle]) -> None:
    """Check what the paper says about cycles in contact."""
    closed = sum(cycle.has_contact for cycle in cycles)
    reduced = sum(cycle.has_contact and cycle.change < 0.0 for cycle in cycles)
    checks.holds(
        f"transverse peaks are lower in most half cycles with backwall contact "
        f"({reduced} of {closed})",
        truth=closed > 0 and 2 * reduced > closed,
        source=_PAPER,
    )
    largest = _largest_change(pair, "deck_uy_m")
    checks.holds(
        f"friction couples the axes without skew: the transverse history changes by {largest:.1%}",
        truth=largest > FEW_PERCENT,
        source=_PAPER,
    )
    correlation = together_correlation(cycles)
    checks.holds(
        f"friction changes most where both axes peak together (rank correlation {correlation:.2f} "
        f"over {len(cycles)} half cycles)",
        truth=correlation > 0.0,
        source=_PAPER,
    )


def _largest_change(pair: Pair, column: str) -> float:
    friction, plain = (histories_of(result)[column] for result in pair)
    count = min(len(friction), len(plain))
    return float(np.abs(friction[:count] - plain[:count]).max() / np.abs(plain).max())


def _key_changes(result: AnalysisResult) -> int:
    table = histories_of(result)
    keys = [name for name in table if "key" in name and name.endswith("_normal_kn")]
    normals = np.column_stack([table[name] for name in keys])
    frictions = np.column_stack(
        [
            np.hypot(
                table[name.replace("normal", "friction_1")],
                table[name.replace("normal", "friction_2")],
            )
            for name in keys
        ]
    )
    return stick_slip_changes(normals, frictions, FRICTION_PCT / 100)


def _row(cycle: HalfCycle) -> dict[str, float | bool]:
    return {
        "start_s": cycle.start_s,
        "end_s": cycle.end_s,
        "peak_without_m": cycle.peak_without_m,
        "peak_with_m": cycle.peak_with_m,
        "change": cycle.change,
        "together": cycle.together,
        "has_contact": cycle.has_contact,
    }
