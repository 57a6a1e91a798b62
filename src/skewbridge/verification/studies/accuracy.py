"""Accuracy of the default numerics: demands against smaller steps, effects against the reference.

`run_convergence` compares the default steps with half a millisecond throughout, and that with a
quarter, on the same model under strong motions. `run_accuracy` compares what friction, gap and skew
change: a study answers by ratios of peaks under the same motion, pooled by their geometric mean
over the motions. Errors that both members of a pair share cancel; the remaining error must be small
compared with the effects. It takes hours, so finished analyses are kept in a file and not repeated.
All peaks are those of whole histories, whether or not columns fail.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import exp, log
from typing import Any, Final

import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.accuracy import NUMERICS, Accuracy, at_accuracy
from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import read_entry
from skewbridge.statuses import COLLAPSE, OK
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.finished import Finished, analysis_key
from skewbridge.verification.statements import relative_change
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import (
    FRICTION_PCT,
    embedded_entries,
    strongest_motions,
)

logger = logging.getLogger(__name__)

type Peaks = Mapping[str, Any]

WINDOW_S: Final = 8.0
PGA_G: Final = 0.8  # closes all gaps, breaks keys, yields columns
# Largest change of a single case and median of all, by demand; None: not limited.
LIMITS: Final[dict[str, tuple[float | None, float | None]]] = {
    **dict.fromkeys(
        (
            "column_shear_kn",
            "column_drift_ratio",
            "deck_disp_x_m",
            "deck_disp_y_m",
            "unseating_m",
            "abutment_passive_m",
            "abutment_transverse_m",
        ),
        (0.02, 0.005),
    ),
    "deck_rotation_rad": (0.03, None),
    **dict.fromkeys(("backwall_force_kn", "shear_key_force_kn", "friction_force_kn"), (None, 0.03)),
    **dict.fromkeys(("slip_work_kj", "friction_impulse_kns", "contact_time_s"), (None, None)),
}
EXCESS: Final = ("cone_excess_wall_ratio", "cone_excess_key_ratio")
MAX_EXCESS: Final = 0.03  # of the work of friction
_HALF_MS: Final = "half a millisecond"
_AGAINST: Final = {"default": "0.5 ms", "0.5 ms": "0.25 ms"}

DEMANDS: Final = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MAX_DIFFERENCE: Final = 0.005  # of a pooled ratio
ALL_PLACES: Final = "all"
_SOURCE: Final = "the same pairs at accuracy reference"


@dataclass(frozen=True, slots=True, kw_only=True)
class ConvergenceSet:
    """Cases of the study of steps: each combination.

    Attributes:
        motion_count: Number of the strongest motions of the suite.
        self_check: Interval of cases at which the reference also runs at half its step.
        processes: Worker processes.
    """

    bridges: tuple[str, ...] = ("osb1", "osb1_fixed")
    skews_deg: tuple[int, ...] = (0, 30, 60)
    gaps_mm: tuple[int, ...] = (25, 51)
    motion_count: int = 4
    self_check: int = 6
    processes: int = 2

    def variants(self) -> list[Variant]:
        """Return the variants."""
        return [
            Variant(
                bridge=bridge,
                abutment="contact_friction",
                skew_deg=skew_deg,
                gap_mm=gap_mm,
                friction_pct=FRICTION_PCT,
            )
            for bridge, skew_deg, gap_mm in product(self.bridges, self.skews_deg, self.gaps_mm)
        ]


def run_steps(study: Study) -> None:
    """Run the study of convergence with the steps."""
    run_convergence(study, ConvergenceSet())


def run_convergence(study: Study, chosen: ConvergenceSet) -> None:
    """Run a set: comparisons of the worst and of the median case, a table of all changes."""
    default = AnalysisSettings(energy=False, mean_iterations=1e4, collapse_drift_ratio=0.5)
    reference = replace(default, **NUMERICS["reference"]["analysis"])
    steps = {
        "default": default,
        "0.5 ms": reference,
        "0.25 ms": replace(reference, dt_s=reference.dt_s / 2),
    }
    motions = [
        cut_to_strongest(motion, WINDOW_S, 0.0)
        for motion in strongest_motions(chosen.motion_count, PGA_G)
    ]
    cases = list(product(chosen.variants(), motions))
    tasks = [
        (variant, motion, name)
        for number, (variant, motion) in enumerate(cases)
        for name in steps
        if name != "0.25 ms" or number % chosen.self_check == 0
    ]
    runs = Parallel(n_jobs=chosen.processes)(
        delayed(_peaks_at_steps)(variant, motion, steps[name]) for variant, motion, name in tasks
    )
    found = {
        (variant.slug, motion.motion_id, name): peaks
        for (variant, motion, name), peaks in zip(tasks, runs, strict=True)
    }
    changes = pd.DataFrame(
        [
            {"variant": slug, "motion_id": motion_id, "steps": name, "against": _AGAINST[name]}
            | {demand: relative_change(peaks[demand], finer[demand]) for demand in LIMITS}
            | {excess: peaks[excess] for excess in EXCESS}
            for (slug, motion_id, name), peaks in found.items()
            if (finer := found.get((slug, motion_id, _AGAINST.get(name, ""))))
        ]
    )
    study.tables["changes"] = changes
    _compare_steps(study, changes)


def _compare_steps(study: Study, changes: pd.DataFrame) -> None:
    of_default = changes[changes["steps"] == "default"]
    of_reference = changes[changes["steps"] == "0.5 ms"]
    cases = f"{len(of_default)} cases"
    for demand, (worst, median) in LIMITS.items():
        # a demand that is absent from both runs of a case has not changed
        sizes = of_default[demand].abs().fillna(0.0)
        own = of_reference[demand].abs().fillna(0.0)
        limits = (("largest", worst, sizes.max()), ("median", median, sizes.median()))
        for name, limit, value in limits:
            text = f"{demand}, {name} change at the default steps, {cases}"
            study.absolute(text, value, 0.0, limit, _HALF_MS)
        text = f"{demand}, largest change of the reference itself, {len(of_reference)} cases"
        study.absolute(text, own.max(), 0.0, None, "a quarter of a millisecond")
    for excess in EXCESS:
        text = f"{excess}, largest of {cases}"
        study.at_most(text, of_default[excess].max(), MAX_EXCESS, "friction law")


def _peaks_at_steps(
    variant: Variant, motion: GroundMotion, settings: AnalysisSettings
) -> dict[str, float]:
    hush_exit_message()
    return analyse(variant, Excitation(motion=motion), settings, ModelOptions()).whole_history


@dataclass(frozen=True, slots=True, kw_only=True)
class AccuracySet:
    """Cases of the study of pairs: each combination; pairs are neighbours on one axis.

    Attributes:
        motion_count: Number of the first motions of the suite, at their scale factors.
        window_s: Strongest part of each motion; None for the whole.
        judged: Accuracy whose ratios are judged.
        exact: Accuracy that they are compared with.
        processes: Worker processes.
    """

    skews_deg: tuple[int, ...] = (0, 30, 60)
    gaps_mm: tuple[int, ...] = (25, 51)
    frictions_pct: tuple[int, ...] = (0, 50)
    motion_count: int = 8
    window_s: float | None = 10.0
    judged: Accuracy = "default"
    exact: Accuracy = "reference"
    processes: int = 2

    def variants(self) -> list[Variant]:
        """Return the variants."""
        return [
            Variant(
                bridge="osb1",
                abutment="contact_friction",
                skew_deg=skew_deg,
                gap_mm=gap_mm,
                friction_pct=friction_pct,
            )
            for skew_deg, gap_mm, friction_pct in product(
                self.skews_deg, self.gaps_mm, self.frictions_pct
            )
        ]

    def motions(self) -> list[GroundMotion]:
        """Return the motions."""
        entries = embedded_entries()[: self.motion_count]
        motions = [read_entry(entry).scaled(entry.scale) for entry in entries]
        if self.window_s is None:
            return motions
        return [cut_to_strongest(motion, self.window_s, 0.0) for motion in motions]

    def pairs(self) -> list[tuple[str, Variant, Variant]]:
        """Return the axis, the variant before and the variant after of every pair."""
        axes = {
            "friction_pct": self.frictions_pct,
            "gap_mm": self.gaps_mm,
            "skew_deg": self.skews_deg,
        }
        return [
            (axis, variant, replace(variant, **{axis: value}))
            for axis, values in axes.items()
            for before, value in pairwise(values)
            for variant in self.variants()
            if getattr(variant, axis) == before
        ]


SETS: Final[Mapping[str, AccuracySet]] = {
    "accuracy": AccuracySet(),
    "accuracy-whole": AccuracySet(window_s=None),
}


def run_pairs(study: Study) -> None:
    """Run the set of the study's name."""
    run_accuracy(study, SETS[study.name])


def run_accuracy(study: Study, chosen: AccuracySet) -> None:
    """Run a set: one comparison per pooled ratio, the largest difference, a table of all."""
    settings = AnalysisSettings(energy=False, mean_iterations=1e4, collapse_drift_ratio=0.5)
    tasks: dict[tuple[Accuracy, Variant, str], tuple[Variant, GroundMotion, Accuracy]] = {
        (accuracy, variant, motion.motion_id): (variant, motion, accuracy)
        for motion in chosen.motions()
        for variant in chosen.variants()
        for accuracy in (chosen.exact, chosen.judged)
    }
    keys = {
        name: analysis_key(variant, motion, *at_accuracy(settings, ModelOptions(), accuracy))
        for name, (variant, motion, accuracy) in tasks.items()
    }
    finished = Finished(study.kept / f"{study.name}.jsonl" if study.kept else None)
    pending = [name for name in tasks if keys[name] not in finished.rows]
    logger.info("%s: %d of %d analyses to run", study.name, len(pending), len(tasks))
    runs = Parallel(n_jobs=chosen.processes, return_as="generator_unordered")(
        delayed(_peaks_at_accuracy)(keys[name], *tasks[name], settings) for name in pending
    )
    for key, peaks in runs:
        finished.add(key, peaks)
    found = {name: finished.rows[key] for name, key in keys.items()}
    motions = list(dict.fromkeys(motion_id for _, _, motion_id in tasks))
    _compare_ratios(study, chosen, pooled_ratios(chosen, found, motions))
    failed = sum(peaks["status"] not in {OK, COLLAPSE} for peaks in found.values())
    study.at_most(f"analyses of {len(found)} that failed", failed, 0.0, "none may fail")


def pooled_ratios(
    chosen: AccuracySet,
    found: Mapping[tuple[Accuracy, Variant, str], Peaks],
    motions: Sequence[str],
) -> pd.DataFrame:
    """Return the pooled ratios of all pairs and demands at both accuracies.

    A pair is pooled over the motions at each place (the values on the other axes), and over motions
    and places together. Motions without the demand in a member are left out.

    Returns:
        axis, from_value, to_value, place, demand, number of ratios, ratio at both accuracies and
        their difference in percent.
    """
    logs: dict[tuple[str, int, int, str, str], list[tuple[float, float]]] = {}
    for axis, before, after in chosen.pairs():
        step = (axis, getattr(before, axis), getattr(after, axis))
        place = ", ".join(
            f"{name} {getattr(before, name)}"
            for name in ("skew_deg", "gap_mm", "friction_pct")
            if name != axis
        )
        for demand, motion_id in product(DEMANDS, motions):
            peaks = [
                float(found[accuracy, variant, motion_id][demand])
                for accuracy in (chosen.judged, chosen.exact)
                for variant in (before, after)
            ]
            if min(peaks) > 0.0:
                changes = (log(peaks[1] / peaks[0]), log(peaks[3] / peaks[2]))
                for where in (place, ALL_PLACES):
                    logs.setdefault((*step, where, demand), []).append(changes)
    return pd.DataFrame(
        [
            dict(zip(("axis", "from_value", "to_value", "place", "demand"), name, strict=True))
            | {"count": len(changes)}
            | _pooled(changes)
            for name, changes in logs.items()
        ]
    )


def _pooled(changes: Sequence[tuple[float, float]]) -> dict[str, float]:
    judged, exact = (exp(sum(values) / len(changes)) for values in zip(*changes, strict=True))
    difference = 100.0 * (judged / exact - 1.0)
    return {"ratio": judged, "exact_ratio": exact, "difference_percent": difference}


def _compare_ratios(study: Study, chosen: AccuracySet, table: pd.DataFrame) -> None:
    study.tables["ratios"] = table
    for row in table.to_dict("records"):
        step = f"{row['axis']} {row['from_value']} to {row['to_value']}, {row['place']}"
        text = f"{step}: {row['demand']}, ratio at {chosen.judged} over {row['count']} pairs"
        study.relative(text, row["ratio"], row["exact_ratio"], MAX_DIFFERENCE, _SOURCE)
    worst = table["difference_percent"].abs().max()
    text = f"largest difference of {len(table)} pooled ratios in percent"
    study.at_most(text, worst, 100.0 * MAX_DIFFERENCE, _SOURCE)


def _peaks_at_accuracy(
    key: str, variant: Variant, motion: GroundMotion, accuracy: Accuracy, settings: AnalysisSettings
) -> tuple[str, dict[str, Any]]:
    hush_exit_message()
    numerics = at_accuracy(settings, ModelOptions(), accuracy)
    result = analyse(variant, Excitation(motion=motion), *numerics)
    peaks = {demand: result.whole_history[demand] for demand in DEMANDS}
    return key, {"variant": variant.slug, "motion_id": motion.motion_id} | peaks | {
        "accuracy": accuracy,
        "status": result.status,
    }
