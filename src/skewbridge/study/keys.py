"""The key of an analysis: equal keys mean equal results."""

from typing import TYPE_CHECKING, Final

from skewbridge.analysis.keys import input_digest
from skewbridge.provenance.digests import digest_of, opensees_version, source_digest

if TYPE_CHECKING:
    from skewbridge.study.task import Task

#: The module that runs one analysis; its closure is what the analyses depend on.
ANALYSIS_MODULE: Final = "skewbridge.study.task"


def run_key(task: "Task") -> str:
    """Return the digest of everything that the result of an analysis depends on."""
    return digest_of(
        input_digest(task.variant, task.motion.motion, task.settings, task.options),
        float(task.motion.scale),
        float(task.incidence_deg),
        source_digest(ANALYSIS_MODULE),
        opensees_version(),
    )
