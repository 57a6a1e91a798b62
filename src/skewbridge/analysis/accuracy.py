"""Named sets of numerics: resolution of an analysis in space and time."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, Literal, get_args

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.files.text import merged
from skewbridge.variant.options import ModelOptions

type Accuracy = Literal["reference", "default", "fast"]

#: By name, the keys of the sections ``analysis`` and ``model`` that a set changes.
NUMERICS: Final[Mapping[str, Mapping[str, Mapping[str, Any]]]] = {
    # Changes at half of this step: docs/theory/analysis.md, convergence.
    "reference": {
        "analysis": {
            "dt_s": 0.0005,
            "contact_dt_s": None,
            "event_dt_s": None,
            "tolerance_j": 1.0e-8,
            "reuse_tangent": False,
        },
        "model": {
            "backwall_points": 9,
            "pads": "each",
            "column_fibers": (12, 32, 3),
            "deck_elements_per_span": 8,
        },
    },
    "default": {"analysis": {}, "model": {}},
    "fast": {
        "analysis": {
            "dt_s": 0.010,
            "contact_dt_s": 0.010,
            "event_dt_s": 0.00125,
            "max_friction_error": 0.1,
            "tolerance_j": 1.0e-2,
        },
        "model": {
            "column_fibers": (4, 12, 1),
            "deck_elements_per_span": 3,
        },
    },
}


def under_explicit_keys(raw: Mapping[str, Any], accuracy: object) -> dict[str, Any]:
    """Return sections of a configuration with a set of numerics below their explicit keys."""
    if accuracy not in NUMERICS:
        known = ", ".join(get_args(Accuracy.__value__))
        raise InputError(f"accuracy must be one of {known}, got {accuracy!r}")
    return merged(NUMERICS[str(accuracy)], raw)


def at_accuracy(
    settings: AnalysisSettings, options: ModelOptions, accuracy: Accuracy
) -> tuple[AnalysisSettings, ModelOptions]:
    """Return settings and options with a set of numerics instead of their own."""
    numerics = NUMERICS[accuracy]
    return replace(settings, **numerics["analysis"]), replace(options, **numerics["model"])
