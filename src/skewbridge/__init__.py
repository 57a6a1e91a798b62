"""Seismic fragility of bridges with seat-type abutments: skew, joint gap and contact-friction."""

from importlib import import_module
from pathlib import Path
from typing import Any


def load(folder: str | Path = "results") -> Any:
    """Read the tables of a study: ``load("results").fragility["curves"]``.

    Every frame has its units in ``attrs["units"]`` and its origin in ``attrs["provenance"]``.
    Warns when tables come from different configurations, motions, commits or versions.

    Args:
        folder: Folder of the study.

    Returns:
        `skewbridge.study.results.Results`.

    Raises:
        InputError: There is no study in the folder, or a table is damaged.
    """
    # Imported by name: modules imported above would count as sources of every analysis.
    return import_module(".study.results", __name__).load_results(Path(folder))


def __getattr__(name: str) -> Any:
    """Return `Frame`, `End` or `Column`, which the script of a user's bridge returns."""
    if name in ("Frame", "End", "Column"):
        return getattr(import_module(".bridge.script_frame", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
