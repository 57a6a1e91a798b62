"""Folders linked to the sources, in which a study runs."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).parents[1]
#: Results that are made before the analyses.
BEFORE: Final = ("results/motions/suite.parquet", "results/verification/contact_checks.parquet")


def linked_sources(folder: Path, study: Mapping[str, Any]) -> None:
    """Link the sources into a folder and write the configuration `study.json` of a study."""
    for part in ("Snakefile", "profiles", "workflow", "src", "config", "motions"):
        if (ROOT / part).exists():
            (folder / part).symlink_to(ROOT / part)
    (folder / "study.json").write_text(json.dumps(study))


def make(folder: Path, *arguments: str, **variables: str) -> None:
    """Run Snakemake on `study.json` in a folder; its messages go to stderr."""
    subprocess.run(
        [sys.executable, "-m", "snakemake", "--configfile", "study.json", *arguments],
        cwd=folder,
        check=True,
        stdout=sys.stderr,
        env=os.environ | variables,
    )
