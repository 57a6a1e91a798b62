"""Figure 10 of the paper: the abutment sub-structure under Tarzana, with and without friction.

Run at skew 0 and at skew 25 degrees, since the paper says both, with the keys of the default model
and with keys that hold, since it does not say which.
"""

from itertools import product
from typing import Final, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.units import KJ, KN, MM
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.abutment_statements import (
    Pair,
    judge_pair,
    judge_source,
    judge_static_push,
)
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    DURATION_S,
    FRICTION_PCT,
    draw_pair,
    paper_variant,
)
from skewbridge.verification.studies.paper_motions import PaperMotion, tarzana

type Keys = Literal["sacrificial", "monolithic"]

SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
KEYS: Final[tuple[Keys, ...]] = ("sacrificial", "monolithic")  # the default model's first
_PAPER: Final = "without friction, this model"


def run(study: Study) -> None:
    """Run the study."""
    motion = tarzana()
    pairs: dict[tuple[Keys, int], Pair] = {
        (keys, skew): _pair(motion, skew, keys) for keys, skew in product(KEYS, SKEWS_DEG)
    }
    for (keys, skew), pair in pairs.items():
        name = _case(motion, skew, keys)
        _report(study, name, pair)
        _check(study, name, pair)
        judge_pair(study, name, pair)
        label = f"skew{skew:02d}_{keys}"
        study.figures[label] = _hysteresis(pair, motion)
        study.tables[f"{label}_ledger"] = _ledger(pair[0])
    judge_static_push(study)
    for skew in SKEWS_DEG:
        alone = {
            place: _history(motion, ModelOptions(friction_at=place), skew)
            for place in ("walls", "keys")
        }
        judge_source(study, _case(motion, skew, KEYS[0]), pairs[KEYS[0], skew], alone)


def _case(motion: PaperMotion, skew_deg: int, keys: Keys) -> str:
    return f"skew {skew_deg}, {keys} keys{motion.stand_in}"


def _pair(motion: PaperMotion, skew_deg: int, keys: Keys) -> Pair:
    """Return the histories with and without friction."""
    options = ModelOptions(keys=keys)
    return (
        _history(motion, options, skew_deg),
        _history(motion, options, skew_deg, friction_pct=0),
    )


def _history(
    motion: PaperMotion, options: ModelOptions, skew_deg: int, friction_pct: int = FRICTION_PCT
) -> AbutmentHistory:
    variant = paper_variant(skew_deg=skew_deg, friction_pct=friction_pct)
    settings = AnalysisSettings(duration_s=DURATION_S)
    return abutment_history(variant, Excitation(motion=motion.motion), settings, options)


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


def _check(study: Study, name: str, pair: Pair) -> None:
    """Check that the histories are whole: what is judged rests on them."""
    is_whole = all(history.is_complete for history in pair)
    text = f"{name}: both histories reach their end"
    study.holds(text, truth=is_whole, source="this model")


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
