"""Convergence of the demands with the steps, under strong motions.

The default steps are compared with half a millisecond throughout, and that with a quarter, on the
same model; peaks are those of whole histories, whatever becomes of the columns.
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.accuracy import NUMERICS
from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.judgement import relative_change
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import FRICTION_PCT
from skewbridge.verification.studies.hard_set import strongest_motions

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
_SOURCE: Final = "half a millisecond"
# What each is compared with.
_AGAINST: Final = {"default": "0.5 ms", "0.5 ms": "0.25 ms"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ConvergenceSet:
    """What is run: each combination.

    Attributes:
        motion_count: How many of the strongest motions of the suite.
        self_check: Every so many cases, the reference is run at half its step.
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


def run(study: Study) -> None:
    """Run the study."""
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
        delayed(_peaks)(variant, motion, steps[name]) for variant, motion, name in tasks
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
    _compare(study, changes)


def _compare(study: Study, changes: pd.DataFrame) -> None:
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
            study.absolute(text, value, 0.0, limit, _SOURCE)
        text = f"{demand}, largest change of the reference itself, {len(of_reference)} cases"
        study.absolute(text, own.max(), 0.0, None, "a quarter of a millisecond")
    for excess in EXCESS:
        text = f"{excess}, largest of {cases}"
        study.at_most(text, of_default[excess].max(), MAX_EXCESS, "friction law")


def _peaks(variant: Variant, motion: GroundMotion, settings: AnalysisSettings) -> dict[str, float]:
    hush_exit_message()
    return analyse(variant, Excitation(motion=motion), settings, ModelOptions()).whole_history
