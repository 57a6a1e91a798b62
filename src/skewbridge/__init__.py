"""Seismic fragility of bridges with seat-type abutments: skew, joint gap and contact-friction."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skewbridge.fragility.exchange.loaded import Results


def load(folder: str | Path = "results") -> "Results":
    """Read the tables of a study: ``load("results").fragility["curves"]``.

    Every frame tells its units in ``attrs["units"]`` and its origin in ``attrs["provenance"]``.
    Warns when tables come from different configurations, motions, commits or versions.

    Args:
        folder: Of the study.

    Raises:
        InputError: There is no study in the folder, or a table is damaged.
    """
    from skewbridge.fragility.exchange.loaded import load_results

    return load_results(Path(folder))
