"""Figure 10 of the paper: the abutment sub-structure under Tarzana, with and without friction.

Run at skew 0 and at skew 25 degrees, since the paper says both.
"""

from typing import Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.units import KJ, KN, MM
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.bridge_cycles import half_cycles, stick_slip_changes
from skewbridge.verification.bridge_records import PaperMotion, tarzana
from skewbridge.verification.checks import Checklist, StudyResult
from skewbridge.verification.figure_style import BLUE, ORANGE, label, legend, panels

FRICTION_PCT: Final = 50  # source: the paper, section 4
GAP_MM: Final = 51  # source: the paper, section 4
SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
DURATION_S: Final = 25.0
_PEAKS: Final = (
    "into the backfill (m)",
    "away from the backfill (m)",
    "transverse (m)",
    "force into the backfill (kN)",
    "transverse force (kN)",
)
_PAPER: Final = "paper, section 4 and figure 10"

type Pair = tuple[AbutmentHistory, AbutmentHistory]


def run() -> StudyResult:
    """Run the study."""
    motion = tarzana()
    checks = Checklist("fig10")
    pairs = {skew: _pair(skew, motion, "sacrificial") for skew in SKEWS_DEG}
    strong = _pair(0, motion, "monolithic")
    for skew, pair in pairs.items():
        _report(checks, f"skew {skew}", pair)
    _report(checks, "skew 0, monolithic keys", strong)
    _statements(checks, pairs[0], strong)
    figures = {f"skew{skew:02d}": _hysteresis(pair, motion) for skew, pair in pairs.items()}
    figures["skew00_monolithic"] = _hysteresis(strong, motion)
    return StudyResult(
        checks=checks.checks,
        figures=figures,
        tables={f"skew{skew:02d}_ledger": _ledger(pair[0]) for skew, pair in pairs.items()},
    )


def _pair(skew_deg: int, motion: PaperMotion, keys: str) -> Pair:
    """Return the histories with and without friction."""
    options = ModelOptions(keys="monolithic" if keys == "monolithic" else "sacrificial")
    settings = AnalysisSettings(duration_s=DURATION_S)
    histories = [
        abutment_history(
            Variant(
                bridge="osb1",
                abutment="contact_friction",
                skew_deg=skew_deg,
                gap_mm=GAP_MM,
                friction_pct=friction,
            ),
            motion.motion,
            settings,
            options,
        )
        for friction in (FRICTION_PCT, 0)
    ]
    return histories[0], histories[1]


def _report(checks: Checklist, name: str, pair: Pair) -> None:
    """Put the peaks with friction beside those without."""
    for quantity, with_friction, without in zip(
        _PEAKS, *(_peaks(history) for history in pair), strict=True
    ):
        checks.report(
            f"{name}: peak {quantity}, friction 0.5 against 0", with_friction, without, _PAPER
        )
    slip_kj = sum(unit.slip_work_j for unit in pair[0].ledger) / KJ
    checks.report(f"{name}: work of friction (kJ)", slip_kj, 0.0, _PAPER)


def _peaks(history: AbutmentHistory) -> list[float]:
    """Return the peaks named in `_PEAKS`."""
    x_m, y_m = history.disp_m.T
    x_n, y_n = history.force_n.T
    return [
        *(float(x_m.max()), float(-x_m.min()), float(np.abs(y_m).max())),
        *(float(x_n.max()) / KN, float(np.abs(y_n).max()) / KN),
    ]


def _statements(checks: Checklist, pair: Pair, strong: Pair) -> None:
    """Check what the paper says about the abutment without skew."""
    with_friction, without = pair
    checks.holds(
        "all histories reach their end without a failed step",
        truth=all(h.is_complete and h.failed_attempts == 0 for h in (*pair, *strong)),
        source="this model",
    )
    checks.relative(
        "skew 0: peak closing into the backfill changes by at most 5 % (m)",
        *(with_friction.disp_m[:, 0].max(), without.disp_m[:, 0].max(), 0.05, _PAPER),
    )
    checks.holds(
        "skew 0: transverse peak is lower with friction, keys that hold",
        truth=bool(np.abs(strong[0].disp_m[:, 1]).max() < np.abs(strong[1].disp_m[:, 1]).max()),
        source=_PAPER,
    )
    walls = [i for i, name in enumerate(without.unit_names) if "backwall" in name]
    in_contact = (without.normals_n[:, walls] > 0.0).any(axis=1)
    cycles = half_cycles(
        *(without.t_s, without.disp_m[:, 1], with_friction.disp_m[:, 1], without.disp_m[:, 0]),
        in_contact,
    )
    lower = sum(cycle.change < 0.0 for cycle in cycles)
    checks.holds(
        f"skew 0: transverse peaks are lower in several cycles ({lower} of {len(cycles)})",
        truth=lower >= 2,
        source=_PAPER,
    )
    keys = [i for i, name in enumerate(with_friction.unit_names) if "key" in name]
    changes = stick_slip_changes(
        with_friction.normals_n[:, keys], with_friction.friction_n[:, keys], FRICTION_PCT / 100
    )
    checks.holds(
        f"skew 0: the keys stick and slip ({changes} changes)", truth=changes >= 10, source=_PAPER
    )


def _hysteresis(pair: Pair, motion: PaperMotion) -> Figure:
    figure, axes = panels(1, 2, height_in=3.0)
    styles = (("friction 0.5", BLUE, 1.0), ("no friction", ORANGE, 0.8))
    for axis, column, title in (
        (axes[0, 0], 0, "longitudinal (u)"),
        (axes[0, 1], 1, "transverse (w)"),
    ):
        for history, (name, colour, width) in reversed(list(zip(pair, styles, strict=True))):
            axis.plot(
                *(history.disp_m[:, column] / MM, history.force_n[:, column] / (1000 * KN)),
                color=colour,
                lw=width,
                label=name,
            )
        label(axis, "displacement (mm)", "force on the deck (MN)", title)
    legend(axes[0, 0], loc="best")
    figure.suptitle(motion.label, fontsize=9)
    return figure


def _ledger(history: AbutmentHistory) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {
                "contact": unit.name,
                "closures": unit.closures,
                "contact_time_s": unit.contact_time_s,
                "max_normal_kn": unit.max_normal_n / KN,
                "max_friction_kn": unit.max_friction_n / KN,
                "slip_work_kj": unit.slip_work_j / KJ,
            }
            for unit in history.ledger
        ]
    )
