"""Copies of the project in which a study runs, and what two runs of it may differ in."""

import shutil
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
#: Measured times may differ between two runs of the same analysis.
TIMES: Final = ["wall_s", "cpu_s"]
_LEFT_OUT: Final = shutil.ignore_patterns(
    ".git",
    ".venv",
    ".uv",
    ".exports",
    ".snakemake",
    "results",
    ".*_cache",
    ".hypothesis",
    "__pycache__",
)


def copy_sources(folder: Path) -> Path:
    """Copy the sources into a new folder, without environments and results; return it."""
    shutil.copytree(ROOT, folder, ignore=_LEFT_OUT)
    return folder
