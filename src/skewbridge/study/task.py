"""One analysis: its inputs, its key and its result.

This module is part of the key of every analysis (`files.digests.ENGINE`), so an edit reruns all
analyses. Scheduling, journals and configuration are therefore in other modules.
"""

import hashlib
import logging
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from math import inf, nan
from pathlib import Path
from typing import Any

from skewbridge.analysis.bridge_check import SUPPORT
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.recovery import steps_as_text
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import Progress
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.bridge.library import load_structure
from skewbridge.errors import InputError
from skewbridge.files.digests import canonical, digest_of, engine_digest, opensees_version
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.statuses import RAN
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import Draw
from skewbridge.variant.variant import Variant

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """All inputs of one analysis; the motion has its scale factor and intensity measures.

    The options include the `draw` of the motion: random properties and alternatives by name.
    If the `supports` have different motions, `motion` is the one of the first bent.
    """

    variant: Variant
    motion: SuiteMotion
    incidence_deg: float
    settings: AnalysisSettings
    options: ModelOptions
    draw: Draw = field(default_factory=dict)
    supports: Mapping[str, GroundMotion] = field(default_factory=dict[str, GroundMotion])

    @property
    def analysed_s(self) -> float:
        """Length of the analysed part of the motion, unless the analysis ends early."""
        longest = self.settings.duration_s
        return min(self.motion.motion.duration_s, inf if longest is None else longest)

    def analyse(self, **options: Any) -> AnalysisResult:
        """Run the analysis in this process, with options of `analysis.transient.analyse`."""
        excitation = Excitation(
            motion=self.motion.motion,
            scale=self.motion.scale,
            incidence_deg=self.incidence_deg,
            supports=self.supports,
        )
        return analyse(self.variant, excitation, self.settings, self.options, **options)


def run_key(task: Task) -> str:
    """Return the digest of everything that the result of an analysis depends on.

    Of the motion, these are the accelerations and time step as analysed, no names or measures.
    """
    return digest_of(
        canonical(asdict(task.variant)),
        _motion_digest(task.motion.motion),
        canonical(asdict(task.settings)),
        canonical(asdict(task.options)),
        load_structure(task.variant.bridge).digest,
        *((name, _motion_digest(motion)) for name, motion in task.supports.items()),
        float(task.motion.scale),
        float(task.incidence_deg),
        engine_digest(),
        opensees_version(),
    )


@lru_cache(maxsize=1024)
def _motion_digest(motion: GroundMotion) -> str:
    digest = hashlib.sha256(repr(float(motion.dt_s)).encode())
    for values in motion.components:
        digest.update(values.astype("<f8").tobytes())
    return digest.hexdigest()[:16]


def analyse_task(task: Task, log_path: Path, progress: Progress) -> dict[str, Any]:
    """Run one analysis in this process and return its columns (`outcome_of` or `no_result`).

    The solver's messages go to the log; `progress` gets the time reached and the duration (s).
    """
    try:
        result = task.analyse(log_path=log_path, progress=progress)
    except InputError as error:
        return no_result("invalid_input", str(error))
    except OSError:  # such as a full disk, not due to the analysis: the study stops
        raise
    except Exception as error:
        logger.exception("%s under %s", task.variant.slug, task.motion.motion.motion_id)
        return no_result("crash", f"{type(error).__name__}: {error}")
    return outcome_of(result)


def outcome_of(result: AnalysisResult) -> dict[str, Any]:
    """Return the columns of a row that an analysis computes: demands and status."""
    reason = "" if result.status in RAN else "; ".join(result.messages)
    return {
        **result.demands,
        "status": result.status,
        "collapse_criterion": result.collapse_criterion or reason,
        "beyond_model": result.model_end.mode,
        "beyond_model_s": result.model_end.time_s,
        SUPPORT: result.support_length_m,
        "time_reached_s": result.time_reached_s,
        "duration_s": result.duration_s,
        "recovery_rung": result.effort.highest_rung,
        "steps_by_rung": steps_as_text(result.effort.counts),
        "substeps": result.effort.substeps,
    }


def no_result(status: str, reason: str) -> dict[str, Any]:
    """Return the columns of an analysis without a result; demands are not included."""
    return {
        "status": status,
        "collapse_criterion": reason,
        "beyond_model": "",
        "beyond_model_s": nan,
        SUPPORT: nan,
        "time_reached_s": 0.0,
        "duration_s": nan,
        "recovery_rung": 0,
        "steps_by_rung": "",
        "substeps": 0,
    }
