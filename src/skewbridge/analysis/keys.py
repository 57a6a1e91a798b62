"""Digests of the inputs of an analysis: equal digests mean equal results of one engine."""

import hashlib
from dataclasses import asdict
from functools import cache, lru_cache

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.files.digests import canonical, digest_of
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


def input_digest(
    variant: Variant, motion: GroundMotion, settings: AnalysisSettings, options: ModelOptions
) -> str:
    """Return the digest of all inputs of an analysis.

    Of the motion these are its accelerations and time step as analysed, whatever files they were
    read from; its name, event and intensity measures are not.
    """
    return digest_of(
        canonical(asdict(variant)),
        motion_digest(motion),
        canonical(asdict(settings)),
        canonical(asdict(options)),
        bridge_digest(variant.bridge),
    )


@lru_cache(maxsize=1024)
def motion_digest(motion: GroundMotion) -> str:
    """Return the digest of the accelerations and the time step of a motion."""
    digest = hashlib.sha256(repr(float(motion.dt_s)).encode())
    for values in motion.components:
        digest.update(values.astype("<f8").tobytes())
    return digest.hexdigest()[:16]


@cache
def bridge_digest(name: str) -> str:
    """Return the digest of a bridge: its numbers and choices, merged from all its files."""
    return digest_of(load_bridge(name).model_dump_json(exclude={"title", "sources"}))
