"""What friction, gap and skew change at the default accuracy, against the same at the reference.

A study answers by ratios of peaks under the same motion, pooled by their geometric mean over the
motions. Errors that both members of a pair share cancel; what is left must be small beside the
effects. Hours of work: finished analyses are kept in a file and not repeated.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import exp, log
from typing import Any, Final

import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.accuracy import Accuracy, at_accuracy
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
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_motions import embedded_entries

logger = logging.getLogger(__name__)

type Peaks = Mapping[str, Any]

DEMANDS: Final = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MAX_DIFFERENCE: Final = 0.005  # of a pooled ratio
ALL_PLACES: Final = "all"
_SOURCE: Final = "the same pairs at accuracy reference"


@dataclass(frozen=True, slots=True, kw_only=True)
class AccuracySet:
    """What is run: each combination; pairs are neighbours on one axis, all else equal.

    Attributes:
        motion_count: How many of the first motions of the suite, at their factors.
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
        """Return the axis, what is compared with, and what is compared, of every pair."""
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


#: By name of the study.
SETS: Final[Mapping[str, AccuracySet]] = {
    "accuracy": AccuracySet(),
    "accuracy-whole": AccuracySet(window_s=None),
}


def run(study: Study) -> None:
    """Run the study."""
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
        delayed(_peaks)(keys[name], *tasks[name], settings) for name in pending
    )
    for key, peaks in runs:
        finished.add(key, peaks)
    found = {name: finished.rows[key] for name, key in keys.items()}
    motions = list(dict.fromkeys(motion_id for _, _, motion_id in tasks))
    _compare(study, chosen, pooled_ratios(chosen, found, motions))
    failed = sum(peaks["status"] not in {OK, COLLAPSE} for peaks in found.values())
    study.at_most(f"analyses of {len(found)} that failed", failed, 0.0, "none may fail")


def pooled_ratios(
    chosen: AccuracySet,
    found: Mapping[tuple[Accuracy, Variant, str], Peaks],
    motions: Sequence[str],
) -> pd.DataFrame:
    """Return the pooled ratios of all pairs and demands at both accuracies.

    The places of a pair are the other axes; a pair is pooled over the motions at each place, and
    over motions and places together. Motions without the demand in a member are left out.

    Returns:
        axis, value before and after, place, demand, number of ratios, ratio at both accuracies and
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


def _compare(study: Study, chosen: AccuracySet, table: pd.DataFrame) -> None:
    study.tables["ratios"] = table
    for row in table.to_dict("records"):
        step = f"{row['axis']} {row['from_value']} to {row['to_value']}, {row['place']}"
        text = f"{step}: {row['demand']}, ratio at {chosen.judged} over {row['count']} pairs"
        study.relative(text, row["ratio"], row["exact_ratio"], MAX_DIFFERENCE, _SOURCE)
    worst = table["difference_percent"].abs().max()
    text = f"largest difference of {len(table)} pooled ratios in percent"
    study.at_most(text, worst, 100.0 * MAX_DIFFERENCE, _SOURCE)


def _peaks(
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
