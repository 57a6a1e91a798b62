"""Stress cases: every abutment model, skew and kind of bridge under strong motions.

The strongest motions of the package's suite are scaled to a PGA (RotD50) of 1.2 g and cut to their
strongest 10 s. Each analysis must end `ok` or in a physical `collapse`, with its criterion named
and its energy accounted for. Finished analyses are kept, so an interrupted run can be resumed.
"""

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.recovery import rung_shares, steps_as_text, steps_from_text
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.demands.suspect import LIMITS
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.record import GroundMotion
from skewbridge.statuses import COLLAPSE, OK
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.finished import Finished, analysis_key
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import FRICTION_PCT, strongest_motions

logger = logging.getLogger(__name__)

PGA_G: Final = 1.2
WINDOW_S: Final = 10.0
GAP_MM: Final = 25
REPORT_EACH: Final = 10  # analyses between two progress lines; failures are reported at once
_GROUP: Final = ["bridge", "abutment", "skew_deg"]


@dataclass(frozen=True, slots=True, kw_only=True)
class HardSet:
    """The stress cases: each combination.

    Attributes:
        motion_count: Number of the strongest motions of the suite.
        processes: Worker processes.
    """

    bridges: tuple[str, ...] = ("osb1", "osb1_fixed", "osb2s")
    abutments: tuple[str, ...] = tuple(ABUTMENTS)
    skews_deg: tuple[int, ...] = (0, 30, 60)
    motion_count: int = 10
    processes: int = 2

    def variants(self) -> list[Variant]:
        """Return the variants."""
        return [
            Variant(
                bridge=bridge,
                abutment=abutment,
                skew_deg=skew_deg,
                gap_mm=GAP_MM,
                friction_pct=FRICTION_PCT,
            )
            for bridge, abutment, skew_deg in product(self.bridges, self.abutments, self.skews_deg)
        ]


def run(study: Study) -> None:
    """Run the study."""
    run_hard_set(study, HardSet())


def run_hard_set(study: Study, chosen: HardSet) -> None:
    """Run stress cases: one comparison per bridge, abutment and skew, a table of all rows."""
    motions = [
        cut_to_strongest(motion, WINDOW_S, 0.0)
        for motion in strongest_motions(chosen.motion_count, PGA_G)
    ]
    table = pd.DataFrame(_rows(study, list(product(chosen.variants(), motions)), chosen.processes))
    for names, group in table.groupby(_GROUP, sort=False):
        bridge, abutment, skew_deg = names
        failed = group[~group["as_it_should"]]
        text = f"{bridge}, {abutment}, skew {skew_deg}: analyses that end ok or in collapse"
        if len(failed):
            text += f" (not: {'; '.join(failed['motion_id'] + ' ' + failed['why'])})"
        sound = len(group) - len(failed)
        study.absolute(text, sound, len(group), 0.0, "every analysis ends as it should")
    study.tables["rows"] = table
    counts = table.groupby([*_GROUP, "status"], sort=False).size()
    study.tables["statuses"] = counts.rename("analyses").reset_index()
    study.tables["rungs"] = pd.DataFrame(rung_shares(map(steps_from_text, table["steps_by_rung"])))


def _rows(
    study: Study, tasks: Sequence[tuple[Variant, GroundMotion]], processes: int
) -> list[dict[str, Any]]:
    """Return the rows of all analyses; those finished by an earlier run are not repeated."""
    finished = Finished(study.kept / f"{study.name}.jsonl" if study.kept else None)
    keys = [analysis_key(*task, AnalysisSettings(), ModelOptions()) for task in tasks]
    left = [number for number, key in enumerate(keys) if key not in finished.rows]
    done, began_s = len(tasks) - len(left), time.monotonic()
    runs = Parallel(n_jobs=processes, return_as="generator_unordered")(
        delayed(_numbered_row)(number, *tasks[number]) for number in left
    )
    for new, (number, row) in enumerate(runs, start=1):
        finished.add(keys[number], row)
        if study.report_progress and (new % REPORT_EACH == 0 or not row["as_it_should"]):
            minutes = (time.monotonic() - began_s) / new * (len(left) - new) / 60
            study.report_progress(
                f"{done + new} of {len(tasks)} analyses, {minutes:.0f} min left; last: "
                f"{tasks[number][0].slug} {row['motion_id']} {row['why']}"
            )
    return [finished.rows[key] for key in keys]


def _numbered_row(
    number: int, variant: Variant, motion: GroundMotion
) -> tuple[int, dict[str, Any]]:
    return number, _row(variant, motion)


def _row(variant: Variant, motion: GroundMotion) -> dict[str, Any]:
    """Return the row of one analysis, with whether it ended as required and why."""
    hush_exit_message()
    row: dict[str, Any] = {
        "bridge": variant.bridge,
        "abutment": variant.abutment,
        "skew_deg": variant.skew_deg,
        "motion_id": motion.motion_id,
    }
    try:
        found = analyse(variant, Excitation(motion=motion), AnalysisSettings(), ModelOptions())
    except Exception as error:
        logger.exception("%s under %s", variant.slug, motion.motion_id)
        why = f"crash: {type(error).__name__}: {error}"
        return row | {"status": "crash", "as_it_should": False, "why": why, "steps_by_rung": ""}
    residual = found.demands["energy_residual_ratio"]
    is_physical = bool(found.collapse_criterion) and abs(residual) <= LIMITS.max_energy_residual
    messages = "; ".join(found.messages)
    return row | {
        "status": found.status,
        "as_it_should": found.status == OK or (found.status == COLLAPSE and is_physical),
        "why": f"{found.status} at {found.time_reached_s:.2f} s {messages}".strip(),
        "collapse_criterion": found.collapse_criterion,
        "energy_residual_ratio": residual,
        "time_reached_s": found.time_reached_s,
        "duration_s": found.duration_s,
        "recovery_rung": found.recovery_rung,
        "steps_by_rung": steps_as_text(found.steps_by_rung),
        "substeps": found.substeps,
        "iterations": found.iterations,
    }
