"""Figure 10 of the paper: the abutment sub-structure under Tarzana, with and without friction.

The paper mentions skew 0 and skew 25 degrees and does not name the kind of keys, so the study runs
both skews, with sacrificial keys (those of the default model) and with monolithic keys.
"""

from collections.abc import Callable
from itertools import product
from typing import Final, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.units import KJ, KN, MM
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import (
    DURATION_S,
    FRICTION_PCT,
    PaperMotion,
    draw_pair,
    half_cycles,
    paper_variant,
    rms_change,
    stick_slip_changes,
    tarzana,
)

type Keys = Literal["sacrificial", "monolithic"]
type Pair = tuple[AbutmentHistory, AbutmentHistory]
"""With friction, without."""

SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
KEYS: Final[tuple[Keys, ...]] = ("sacrificial", "monolithic")  # the default model's first
FAST_HZ: Final = 5.0
PUSH_M: Final = 0.09
_PAPER: Final = "without friction, this model"


def run(study: Study) -> None:
    """Run the study."""
    motion = tarzana()
    pairs: dict[tuple[Keys, int], Pair] = {}
    for keys, skew in product(KEYS, SKEWS_DEG):
        options = ModelOptions(keys=keys)
        pair = _history(motion, options, skew), _history(motion, options, skew, friction_pct=0)
        pairs[keys, skew] = pair
    for (keys, skew), pair in pairs.items():
        case = f"skew {skew}, {keys} keys{motion.stand_in}"
        _report(study, case, pair)
        _judge(study, case, pair)
        label = f"skew{skew:02d}_{keys}"
        study.figures[label] = _hysteresis(pair, motion)
        study.tables[f"{label}_ledger"] = _ledger(pair[0])
    _judge_static_push(study)
    for skew in SKEWS_DEG:
        without = pairs[KEYS[0], skew][1].disp_m
        changes = (
            rms_change(_history(motion, ModelOptions(friction_at=place), skew).disp_m, without)
            for place in ("walls", "keys")
        )
        case = f"skew {skew}, {KEYS[0]} keys{motion.stand_in}"
        study.states("backwall makes it", case, *(float(change[1]) for change in changes))


def _history(
    motion: PaperMotion, options: ModelOptions, skew_deg: int, friction_pct: int = FRICTION_PCT
) -> AbutmentHistory:
    variant = paper_variant(skew_deg=skew_deg, friction_pct=friction_pct)
    settings = AnalysisSettings(duration_s=DURATION_S)
    return abutment_history(variant, Excitation(motion=motion.motion), settings, options)


def _report(study: Study, case: str, pair: Pair) -> None:
    """Report the peaks with friction against those without; check that both histories finish."""
    with_friction, without = (_peaks(history) for history in pair)
    for quantity, value in with_friction.items():
        text = f"{case}: peak {quantity}, friction 0.5 against 0"
        study.report(text, value, without[quantity], _PAPER)
    slip_kj = sum(unit.slip_work_j for unit in pair[0].ledger) / KJ
    study.report(f"{case}: work of friction (kJ)", slip_kj, 0.0, _PAPER)
    is_whole = all(history.is_complete for history in pair)
    text = f"{case}: both histories reach their end"
    study.holds(text, truth=is_whole, source="this model")


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


def _judge(study: Study, case: str, pair: Pair) -> None:
    """Judge the statements on the loops of one case with friction against those without."""

    def both(value: Callable[[AbutmentHistory], float]) -> list[float]:
        return [float(value(history)) for history in pair]

    for name, peaks in (
        ("into the fill", both(lambda h: h.disp_m[:, 0].max())),
        ("away from the fill", both(lambda h: (-h.disp_m[:, 0]).max())),
        ("force into the fill", both(lambda h: h.force_n[:, 0].max())),
    ):
        study.states("longitudinal hardly changes", f"{case}, {name}", *peaks)
    with_friction, without = pair
    keys = _units(with_friction, "key")
    changes = stick_slip_changes(
        with_friction.normals_n[:, keys], with_friction.friction_n[:, keys], FRICTION_PCT / 100
    )
    study.states("keys stick and slip", case, changes)
    fast = both(lambda h: _fast_rms(h.t_s, h.force_n[:, 0]) / KN)
    study.states("fast vibration", case, *fast)
    along, across = rms_change(with_friction.disp_m, without.disp_m).tolist()
    study.states("transverse differs more", f"{case}, RMS of the displacement", across, along)
    along, across = _work_changes(pair)
    study.states("transverse differs more", f"{case}, work of the loops", across, along)
    closures = sum(unit.closures for unit in with_friction.ledger if "backwall" in unit.name)
    study.states("several contacts", case, closures)
    study.states("transverse peak", case, *both(lambda h: np.abs(h.disp_m[:, 1]).max()))
    count = min(len(with_friction.t_s), len(without.t_s))
    in_contact = np.logical_or.reduce(
        [(h.normals_n[:count, _units(h, "backwall")] > 0.0).any(axis=1) for h in pair]
    )
    cycles = half_cycles(
        without.t_s[:count],
        without.disp_m[:count, 1],
        with_friction.disp_m[:count, 1],
        without.disp_m[:count, 0],
        in_contact,
    )
    lower = [cycle.change < 0.0 for cycle in cycles if cycle.has_contact]
    study.states("transverse cycles", case, sum(lower), len(lower))


def _units(history: AbutmentHistory, kind: str) -> list[int]:
    return [index for index, name in enumerate(history.unit_names) if kind in name]


def _fast_rms(t_s: Array, force_n: Array) -> float:
    """Return the RMS of the frequencies above `FAST_HZ`, on a regular grid of the same length."""
    grid_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    spectrum = np.fft.rfft(np.interp(grid_s, t_s, force_n))
    spectrum[np.fft.rfftfreq(len(grid_s), grid_s[1] - grid_s[0]) < FAST_HZ] = 0.0
    return float(np.sqrt(np.mean(np.fft.irfft(spectrum, len(grid_s)) ** 2)))


def _work_changes(pair: Pair) -> tuple[float, float]:
    """Return the relative changes of the work of the loops along x and y by friction."""
    rough, smooth = (
        [np.trapezoid(h.force_n[:, axis], h.disp_m[:, axis]) for axis in (0, 1)] for h in pair
    )
    along, across = (abs(one / other - 1.0) for one, other in zip(rough, smooth, strict=True))
    return float(along), float(across)


def _judge_static_push(study: Study) -> None:
    """Judge whether a push along one axis without skew is independent of friction."""
    for axis, angle_deg in (("longitudinal", 0.0), ("transverse", 90.0)):
        rough, smooth = (
            push_abutment(
                paper_variant(friction_pct=friction_pct),
                ModelOptions(),
                angle_deg=angle_deg,
                max_disp_m=PUSH_M,
            ).force_n
            for friction_pct in (FRICTION_PCT, 0)
        )
        change = float(np.abs(rough - smooth).max() / np.abs(smooth).max())
        study.states("static push", f"skew 0, {axis}", change)


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
