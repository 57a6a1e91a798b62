"""The key of an analysis: equal keys mean equal results."""

import hashlib
from dataclasses import asdict
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Final

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.provenance.digests import canonical, digest_of, opensees_version, source_digest

if TYPE_CHECKING:
    from skewbridge.motions.record import GroundMotion
    from skewbridge.study.task import Task

#: The module that runs one analysis; its closure is what the analyses depend on.
ANALYSIS_MODULE: Final = "skewbridge.study.task"


def run_key(task: "Task") -> str:
    """Return the digest of everything that the result of an analysis depends on.

    Of the motion these are its accelerations and time step as analysed, whatever files they were
    read from; its name, event and intensity measures are not.
    """
    return digest_of(
        canonical(asdict(task.variant)),
        motion_digest(task.motion.motion),
        float(task.motion.scale),
        float(task.incidence_deg),
        canonical(asdict(task.settings)),
        canonical(asdict(task.options)),
        bridge_digest(task.variant.bridge),
        source_digest(ANALYSIS_MODULE),
        opensees_version(),
    )


@lru_cache(maxsize=1024)
def motion_digest(motion: "GroundMotion") -> str:
    """Return the digest of the accelerations and the time step of a motion."""
    digest = hashlib.sha256(repr(float(motion.dt_s)).encode())
    for values in (motion.accel_1_mps2, motion.accel_2_mps2):
        digest.update(values.astype("<f8").tobytes())
    return digest.hexdigest()[:16]


@cache
def bridge_digest(name: str) -> str:
    """Return the digest of a bridge: its numbers and choices, merged from all its files.

    Raises:
        InputError: Unknown name, or a bad file.
    """
    return digest_of(load_bridge(name).model_dump_json(exclude={"title", "sources"}))
