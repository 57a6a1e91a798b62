"""Figure 10 of the paper: the abutment sub-structure under Tarzana, with and without friction.

Run at skew 0 and at skew 25 degrees, since the paper says both.
"""

from typing import Final, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.units import KJ, KN, MM
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    DURATION_S,
    FRICTION_PCT,
    draw_pair,
    stick_slip_changes,
    with_and_without,
)
from skewbridge.verification.studies.half_cycles import half_cycles
from skewbridge.verification.studies.paper_motions import PaperMotion, tarzana

SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
_PAPER: Final = "paper, section 4 and figure 10"

type Pair = tuple[AbutmentHistory, AbutmentHistory]


def run(study: Study) -> None:
    """Run the study."""
    motion = tarzana()
    pairs = {f"skew {skew}": _pair(skew, motion, "sacrificial") for skew in SKEWS_DEG}
    pairs["skew 0, monolithic keys"] = _pair(0, motion, "monolithic")
    for name, pair in pairs.items():
        _report(study, name, pair)
    straight, skewed, strong = pairs.values()
    _statements(study, straight, strong)
    for name, pair in (("skew00", straight), ("skew25", skewed)):
        study.figures[name] = _hysteresis(pair, motion)
        study.tables[f"{name}_ledger"] = _ledger(pair[0])
    study.figures["skew00_monolithic"] = _hysteresis(strong, motion)


def _pair(skew_deg: int, motion: PaperMotion, keys: Literal["sacrificial", "monolithic"]) -> Pair:
    """Return the histories with and without friction."""
    options, settings = ModelOptions(keys=keys), AnalysisSettings(duration_s=DURATION_S)

    def history(variant: Variant) -> AbutmentHistory:
        return abutment_history(variant, Excitation(motion=motion.motion), settings, options)

    return with_and_without(history, skew_deg=skew_deg)


def _report(study: Study, name: str, pair: Pair) -> None:
    """Put the peaks with friction beside those without."""
    with_friction, without = (_peaks(history) for history in pair)
    for quantity, value in with_friction.items():
        text = f"{name}: peak {quantity}, friction 0.5 against 0"
        study.report(text, value, without[quantity], _PAPER)
    slip_kj = sum(unit.slip_work_j for unit in pair[0].ledger) / KJ
    study.report(f"{name}: work of friction (kJ)", slip_kj, 0.0, _PAPER)


def _peaks(history: AbutmentHistory) -> dict[str, float]:
    x_m, y_m = history.disp_m.T
    x_n, y_n = history.force_n.T
    return {
        "into the backfill (m)": float(x_m.max()),
        "away from the backfill (m)": float(-x_m.min()),
        "transverse (m)": float(np.abs(y_m).max()),
        "force into the backfill (kN)": float(x_n.max()) / KN,
        "transverse force (kN)": float(np.abs(y_n).max()) / KN,
    }


def _statements(study: Study, pair: Pair, strong: Pair) -> None:
    """Check what the paper says about the abutment without skew."""
    with_friction, without = pair
    study.holds(
        "all histories reach their end without a failed step",
        truth=all(h.is_complete and h.failed_attempts == 0 for h in (*pair, *strong)),
        source="this model",
    )
    text = "skew 0: peak closing into the backfill changes by at most 5 % (m)"
    closing_m, exact_m = (history.disp_m[:, 0].max() for history in pair)
    study.relative(text, closing_m, exact_m, 0.05, _PAPER)
    across_m = [np.abs(history.disp_m[:, 1]).max() for history in strong]
    text = "skew 0: transverse peak is lower with friction, keys that hold"
    study.holds(text, truth=bool(across_m[0] < across_m[1]), source=_PAPER)
    walls = [i for i, name in enumerate(without.unit_names) if "backwall" in name]
    cycles = half_cycles(
        without.t_s,
        without.disp_m[:, 1],
        with_friction.disp_m[:, 1],
        without.disp_m[:, 0],
        (without.normals_n[:, walls] > 0.0).any(axis=1),
    )
    lower = sum(cycle.change < 0.0 for cycle in cycles)
    text = f"skew 0: transverse peaks are lower in several cycles ({lower} of {len(cycles)})"
    study.holds(text, truth=lower >= 2, source=_PAPER)
    keys = [i for i, name in enumerate(with_friction.unit_names) if "key" in name]
    changes = stick_slip_changes(
        with_friction.normals_n[:, keys], with_friction.friction_n[:, keys], FRICTION_PCT / 100
    )
    text = f"skew 0: the keys stick and slip ({changes} changes)"
    study.holds(text, truth=changes >= 10, source=_PAPER)


def _hysteresis(pair: Pair, motion: PaperMotion) -> Figure:
    figure, axes = style.panels(1, 2, height_in=3.0)
    for column, title in enumerate(("longitudinal (u)", "transverse (w)")):
        curves = [(h.disp_m[:, column] / MM, h.force_n[:, column] / (1000 * KN)) for h in pair]
        draw_pair(axes[0, column], *curves)
        style.label(axes[0, column], "displacement (mm)", "force on the deck (MN)", title)
    style.legend(axes[0, 0], loc="best")
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
