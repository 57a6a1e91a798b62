"""What the paper states of the rigid skew deck of figures 5 and 6, judged by its runs."""

from dataclasses import dataclass
from math import isclose
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.verification.judgement import (
    SMALL,
    Judgement,
    at_least,
    at_most,
    cannot_be_told,
    decided,
    grows_with,
)
from skewbridge.verification.references.deck_cases import LENGTH_M, SCALE_M
from skewbridge.verification.references.deck_model import DeckHistory
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.deck_impacts import impacts

_PAPER_RESTITUTION: Final = (0.45, 0.71)  # source: the paper, section 3.1
_LOCKED_LIMIT: Final = 0.01
_AXES: Final = ("ux", "uy", "rotation x length")
# Pairs of cases that differ in one thing only.
_DIFFERING: Final = {"width": ("C1", "C3"), "skew": ("C4", "C5"), "friction": ("C3", "C4")}


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckRuns:
    """Histories of the tabulated cases by name, and the tables of the study.

    Attributes:
        elastic: OpenSees, elastic penalty.
        damped: OpenSees, stiff penalty with the damper of restitution 0.6.
        rigid: Complementarity solution with restitution 0.6.
        locked: The damped penalty that cannot rotate, by stiffness.
        bounced: Impacts under Houbolt, by step.
    """

    elastic: dict[str, DeckHistory]
    damped: dict[str, DeckHistory]
    rigid: dict[str, DeckHistory]
    locked: pd.DataFrame
    bounced: pd.DataFrame


def judge_deck(study: Study, runs: DeckRuns) -> None:
    """Judge what the paper says of figures 5 and 6."""
    _judge_agreement(study, runs)
    _judge_cause(study, runs)
    _judge_restitution(study, runs.bounced)
    for name, (one, other) in _DIFFERING.items():
        turns = [_scaled(runs.rigid[case])[:, 2] for case in (one, other)]
        peaks = [float(np.abs(turn).max()) for turn in turns]
        case = f"{name} ({one} and {other})"
        text = "change of the peak rotation x length over the scale"
        judged = at_least(text, abs(peaks[1] - peaks[0]), SMALL)
        study.states("depends on plan and friction", case, judged)


def _scaled(history: DeckHistory) -> Array:
    """Return ux, uy and rotation x length over the scale of displacement, shape (n, 3)."""
    return history.q * np.array([1.0, 1.0, LENGTH_M]) / SCALE_M


def _difference(history: DeckHistory, rigid: DeckHistory) -> Array:
    """Return the difference of two histories at the times of the first, over the scale."""
    columns = [np.interp(history.t_s, rigid.t_s, column) for column in _scaled(rigid).T]
    return _scaled(history) - np.array(columns).T


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(values**2, axis=0))


def _judge_agreement(study: Study, runs: DeckRuns) -> None:
    """Judge figure 5 axis by axis, and whether differences grow with the impacts."""
    elastic, rigid = runs.elastic["C1"], runs.rigid["C1"]
    difference = _difference(elastic, rigid)
    peaks = np.abs(_scaled(rigid)).max(axis=0)
    for axis, rms, peak in zip(_AXES, _rms(difference), peaks, strict=True):
        over, unit = (1.0, "scale") if isclose(peak, 0.0, abs_tol=1e-9) else (peak, "rigid peak")
        judged = at_most(f"RMS difference over the {unit}", float(rms / over), 2 * SMALL)
        study.states("deck agrees", f"C1, elastic penalty, {axis}", judged)
    times_s = impacts(elastic)["t_s"].to_numpy()
    if len(times_s) < 2:
        judged = cannot_be_told(f"{len(times_s)} impacts")
    else:
        late = elastic.t_s > float(np.median(times_s))
        moved = _scaled(elastic)
        early, later = (
            float(np.hypot(*_rms(difference[part])[:2]) / np.hypot(*_rms(moved[part])[:2]))
            for part in (~late, late)
        )
        reason = (
            f"RMS over that of the motion {early:.3f} before half of the impacts, {later:.3f} after"
        )
        judged = decided(later > early, reason, later, early)
    study.states("differences grow", "C1, elastic penalty", judged)


def _judge_cause(study: Study, runs: DeckRuns) -> None:
    """Judge whether a stiff penalty with restitution removes the differences."""
    rms = runs.locked["rms_ratio"].to_numpy()
    text = f"RMS over the scale falls from {rms[0]:.3f} to {rms[-1]:.4f} as the penalty stiffens"
    converges = bool(np.all(np.diff(rms) < 0.0)) and rms[-1] <= _LOCKED_LIMIT
    judged = decided(converges, text, float(rms[-1]), _LOCKED_LIMIT)
    study.states("penalty is the cause", "C1, rotation locked", judged)
    for case, rigid in runs.rigid.items():
        errors = [_worst(found[case], rigid) for found in (runs.elastic, runs.damped)]
        text = "worst peak of ux, uy, rotation x length off, over the scale, stiff and damped"
        study.states("penalty is the cause", case, at_most(text, errors[1], 2 * SMALL))
        reason = f"worst peak off by {errors[0]:.3f} of the scale elastic, {errors[1]:.3f} damped"
        damped = decided(errors[1] < errors[0], reason, errors[1], errors[0])
        study.states("damper helps", case, damped)


def _worst(history: DeckHistory, rigid: DeckHistory) -> float:
    """Return the largest difference of the three peaks over the scale."""
    peaks = [np.abs(_scaled(found)).max(axis=0) for found in (history, rigid)]
    return float(np.abs(peaks[0] - peaks[1]).max())


def _judge_restitution(study: Study, bounced: pd.DataFrame) -> None:
    """Judge the restitution by step: the paper gives no mass, and so no step over its period."""
    groups = list(bounced.groupby("step_times_frequency"))
    low, high = _PAPER_RESTITUTION
    medians = [float(group["restitution"].median()) for _, group in groups]
    listed = ", ".join(
        f"{median:.2f} at {step:g}" for (step, _), median in zip(groups, medians, strict=True)
    )
    reason = f"median restitution by step x contact frequency: {listed}"
    within = [median for median in medians if low <= median <= high]
    judged = decided(bool(within), reason, within[0] if within else medians[0], high)
    study.states("restitution found", "C1, Houbolt, some step of the table", judged)
    for step, group in groups:
        study.states("restitution falls", f"C1, Houbolt, step {step:g}", _falls(group))


def _falls(group: pd.DataFrame) -> Judgement:
    approach, restitution = group["approach_mps"].tolist(), group["restitution"].to_numpy()
    return grows_with("loss against approach speed", approach, (-restitution).tolist())
