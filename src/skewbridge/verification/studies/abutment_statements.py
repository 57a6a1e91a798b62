"""What the paper states of the abutment of figure 10, judged case by case."""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from skewbridge.analysis.abutment_history import AbutmentHistory
from skewbridge.analysis.pushover import push_abutment
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.judgement import (
    Judgement,
    at_least,
    at_most,
    cannot_be_told,
    decided,
    hardly_changed,
    lower,
    more_often,
)
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    FRICTION_PCT,
    paper_variant,
    stick_slip_changes,
)
from skewbridge.verification.studies.half_cycles import half_cycles

type Pair = tuple[AbutmentHistory, AbutmentHistory]
"""With friction, without."""

FAST_HZ: Final = 5.0  # ASSUME what the paper calls high frequency: above the modes of the deck
FEWEST_CHANGES: Final = 10  # ASSUME "events", many of them
FEWEST_CONTACTS: Final = 2  # "multiple"
PUSH_M: Final = 0.09
SAME_FORCE: Final = 1e-6


def judge_pair(study: Study, case: str, pair: Pair) -> None:
    """Judge the loops of one case with friction against those without."""
    with_friction, without = pair
    for name, value, reference in (
        ("into the fill", *_maxima(pair, lambda h: h.disp_m[:, 0])),
        ("away from the fill", *_maxima(pair, lambda h: -h.disp_m[:, 0])),
        ("force into the fill", *_maxima(pair, lambda h: h.force_n[:, 0])),
    ):
        judged = hardly_changed(f"longitudinal peak, {name},", value, reference)
        study.states("longitudinal hardly changes", f"{case}, {name}", judged)
    keys = _units(with_friction, "key")
    changes = stick_slip_changes(
        with_friction.normals_n[:, keys], with_friction.friction_n[:, keys], FRICTION_PCT / 100
    )
    study.states("keys stick and slip", case, at_least("changes", changes, FEWEST_CHANGES))
    study.states("fast vibration", case, _fast_vibration(pair))
    for name, (along, across) in (
        ("RMS of the displacement", _history_changes(with_friction, without)),
        ("work of the loops", _work_changes(pair)),
    ):
        reason = f"change of {name} {across:.1%} transverse, {along:.1%} longitudinal"
        judged = decided(across > along, reason, across, along)
        study.states("transverse differs more", f"{case}, {name}", judged)
    closures = sum(unit.closures for unit in with_friction.ledger if "backwall" in unit.name)
    judged = at_least("closures of backwall contacts", closures, FEWEST_CONTACTS)
    study.states("several contacts", case, judged)
    peaks = _maxima(pair, lambda h: np.abs(h.disp_m[:, 1]))
    study.states("transverse peak", case, lower("transverse peak", *peaks))
    study.states("transverse cycles", case, _cycles_in_contact(pair))


def judge_static_push(study: Study) -> None:
    """Judge that without skew a push along one axis does not feel friction."""
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
        judged = at_most("largest change of the force over its peak", change, SAME_FORCE)
        study.states("static push", f"skew 0, {axis}", judged)


def judge_source(study: Study, case: str, pair: Pair, alone: Mapping[str, AbutmentHistory]) -> None:
    """Judge whether friction at the backwall alone makes the transverse difference.

    Args:
        study: Where it is put.
        case: Name of the pair.
        pair: With friction everywhere and nowhere.
        alone: With friction at the `walls` and at the `keys` only.
    """
    plain = pair[1]
    everywhere, walls, keys = (
        _history_changes(found, plain)[1] for found in (pair[0], alone["walls"], alone["keys"])
    )
    reason = (
        f"RMS change of the transverse displacement {everywhere:.1%}; walls alone {walls:.1%}, "
        f"keys alone {keys:.1%}"
    )
    study.states("backwall makes it", case, decided(walls > keys, reason, walls, keys))


def _maxima(pair: Pair, of: Callable[[AbutmentHistory], Array]) -> tuple[float, float]:
    return float(of(pair[0]).max()), float(of(pair[1]).max())


def _units(history: AbutmentHistory, kind: str) -> list[int]:
    return [index for index, name in enumerate(history.unit_names) if kind in name]


def _history_changes(history: AbutmentHistory, plain: AbutmentHistory) -> tuple[float, float]:
    """Return the RMS change along x and y over the RMS of the plain displacement."""
    count = min(len(history.t_s), len(plain.t_s))
    change = history.disp_m[:count] - plain.disp_m[:count]
    along, across = np.sqrt((change**2).mean(axis=0) / (plain.disp_m[:count] ** 2).mean(axis=0))
    return float(along), float(across)


def _work_changes(pair: Pair) -> tuple[float, float]:
    """Return how much the work of the loops along x and y changes, over that without friction."""
    rough, smooth = (
        [np.trapezoid(h.force_n[:, axis], h.disp_m[:, axis]) for axis in (0, 1)] for h in pair
    )
    along, across = (abs(one / other - 1.0) for one, other in zip(rough, smooth, strict=True))
    return float(along), float(across)


def _fast_vibration(pair: Pair) -> Judgement:
    """Judge whether friction adds fast vibration to the longitudinal force."""
    rough, smooth = (_fast_rms(history.t_s, history.force_n[:, 0]) for history in pair)
    reason = (
        f"RMS of the longitudinal force above {FAST_HZ:g} Hz {rough / KN:.1f} kN with friction, "
        f"{smooth / KN:.1f} kN without"
    )
    return decided(rough > smooth, reason, rough / KN, smooth / KN)


def _fast_rms(t_s: Array, force_n: Array) -> float:
    """Return the RMS of what is faster than `FAST_HZ`, on a regular grid of the same length."""
    grid_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    spectrum = np.fft.rfft(np.interp(grid_s, t_s, force_n))
    spectrum[np.fft.rfftfreq(len(grid_s), grid_s[1] - grid_s[0]) < FAST_HZ] = 0.0
    return float(np.sqrt(np.mean(np.fft.irfft(spectrum, len(grid_s)) ** 2)))


def _cycles_in_contact(pair: Pair) -> Judgement:
    with_friction, without = pair
    count = min(len(with_friction.t_s), len(without.t_s))
    contact = np.logical_or.reduce(
        [(h.normals_n[:count, _units(h, "backwall")] > 0.0).any(axis=1) for h in pair]
    )
    cycles = half_cycles(
        without.t_s[:count],
        without.disp_m[:count, 1],
        with_friction.disp_m[:count, 1],
        without.disp_m[:count, 0],
        contact,
    )
    closed = [cycle for cycle in cycles if cycle.has_contact]
    if not closed:
        return cannot_be_told("the backwall stays open")
    reduced = sum(cycle.change < 0.0 for cycle in closed)
    return more_often("transverse peaks lower, half cycles in contact", reduced, len(closed))
