"""OSB1 under all abutment models, with skew, and OSB2S: what the choice of model changes.

The paper's section 6 announces these comparisons; the statements on skew are those of its
introduction (after Wu et al. and Maragakis and Jennings).
"""

from typing import Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.result import RAN, AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.units import MM
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENT_CODES, Variant
from skewbridge.verification.bridge_figures_11_12 import DURATION_S, FRICTION_PCT, GAP_MM
from skewbridge.verification.bridge_history_figures import histories_of
from skewbridge.verification.bridge_records import PaperMotion, waho
from skewbridge.verification.checks import Checklist, StudyResult
from skewbridge.verification.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    label,
    legend,
    panels,
)

SKEWS_DEG: Final = (0, 30)
_COLOURS: Final = dict(zip(ABUTMENT_CODES, (GREY, PINK, GREEN, ORANGE, BLUE), strict=True))
_DEMANDS: Final = (
    "deck_disp_m",
    "deck_rotation_rad",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "acute_corner_unseating_m",
    "bearing_disp_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)

type Runs = dict[tuple[str, int], AnalysisResult]


def run() -> StudyResult:
    """Run the study."""
    motion = waho()
    checks = Checklist("ladder")
    runs: Runs = {
        (abutment, skew): _analyse("osb1", abutment, skew, motion)
        for abutment in ABUTMENT_CODES
        for skew in SKEWS_DEG
    }
    checks.holds(
        "OSB1: every abutment model and skew ends with status ok or collapse",
        truth=all(result.status in RAN for result in runs.values()),
        source="this model",
    )
    _skew_statements(checks, runs)
    second = {
        friction: _analyse("osb2s", "contact_friction", 20, motion, friction)
        for friction in (FRICTION_PCT, 0)
    }
    for demand in _DEMANDS:
        checks.report(
            f"OSB2S (surrogate), skew 20: {demand}, friction 0.5 against 0",
            second[FRICTION_PCT].demands[demand],
            second[0].demands[demand],
            "paper, section 6",
        )
    return StudyResult(
        checks=checks.checks,
        figures={f"skew{skew:02d}": _figure(runs, skew, motion) for skew in SKEWS_DEG},
        tables={"demands": _table(runs)},
    )


def _analyse(
    bridge: str, abutment: str, skew_deg: int, motion: PaperMotion, friction_pct: int = FRICTION_PCT
) -> AnalysisResult:
    variant = Variant(
        bridge=bridge,
        abutment=abutment,
        skew_deg=skew_deg,
        gap_mm=GAP_MM,
        friction_pct=friction_pct,
    )
    settings = AnalysisSettings(duration_s=DURATION_S)
    return analyse(
        variant.normalised(), motion.motion, 1.0, 0.0, settings, ModelOptions(), histories=True
    )


def _skew_statements(checks: Checklist, runs: Runs) -> None:
    source = "paper, section 1 and 3.2"
    straight, skewed = (runs["contact", skew].demands for skew in SKEWS_DEG)
    turns = [1e3 * demands["deck_rotation_rad"] for demands in (straight, skewed)]
    checks.holds(
        f"without friction the skewed deck rotates, the straight one hardly "
        f"({turns[1]:.2f} against {turns[0]:.2f} mrad)",
        truth=turns[1] > 2.0 * turns[0],
        source=source,
    )
    straight, skewed = (runs["contact_friction", skew].demands for skew in SKEWS_DEG)
    checks.report(
        "deck_rotation_rad with friction, skew 30 against 0",
        *(skewed["deck_rotation_rad"], straight["deck_rotation_rad"], source),
    )
    checks.relative(
        "skew 30: the acute corner moves farthest from its seat (m)",
        *(skewed["acute_corner_unseating_m"], skewed["unseating_m"], 1e-12, source),
    )
    checks.report(
        "unseating_m, skew 30 against 0", skewed["unseating_m"], straight["unseating_m"], source
    )


def _table(runs: Runs) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"abutment": abutment, "skew_deg": skew, "status": result.status}
            | {demand: result.demands[demand] for demand in _DEMANDS}
            for (abutment, skew), result in runs.items()
        ]
    )


def _figure(runs: Runs, skew: int, motion: PaperMotion) -> Figure:
    figure, axes = panels(3, 1, height_in=5.4, sharex=True)
    for axis, column, unit, name in (
        (axes[0, 0], "deck_ux_m", MM, "longitudinal (mm)"),
        (axes[1, 0], "deck_uy_m", MM, "transverse (mm)"),
        (axes[2, 0], "deck_rot_rad", 1e-3, "rotation (mrad)"),
    ):
        for abutment, colour in _COLOURS.items():
            table = histories_of(runs[abutment, skew])
            axis.plot(
                *(table["t_s"], table[column] / unit),
                color=colour,
                lw=0.9,
                label=abutment.replace("_", " "),
            )
        axis.axhline(0.0, color=BLACK, lw=0.4)
        label(axis, "", name)
    label(axes[2, 0], "time (s)", "rotation (mrad)")
    legend(axes[0, 0], loc="upper right", ncols=5)
    figure.suptitle(f"OSB1, skew {skew}; {motion.label}", fontsize=9)
    return figure
