"""Overhead of the workflow: wall time of the analysis stage over its ideal time on the cores.

Snakemake runs a synthetic study with many motions per variant, from its motions to its table of
demands. The stage consists of the analysis jobs and the job that joins their tables, including the
start of their processes. Prints one JSON object:
    python benchmarks/pipeline.py [--motions 40] [--variants 2] [--duration-s 10] [--cores 2]
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import pandas as pd
from common import ROOT, options, show

GAPS_MM = (25, 51, 38, 64, 12, 76)
# made before the analyses
BEFORE = ("results/motions/suite.parquet", "results/verification/contact_checks.parquet")


def make(folder: Path, *arguments: str) -> None:
    """Run Snakemake on `study.json` in a folder; its messages go to stderr."""
    subprocess.run(
        [sys.executable, "-m", "snakemake", "--configfile", "study.json", *arguments],
        cwd=folder,
        check=True,
        stdout=sys.stderr,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )


def pipeline(
    *, motions: int, variants: int, duration_s: float | None, cores: int
) -> dict[str, Any]:
    """Run a study of motions and gaps in a new folder and return its times.

    Returns:
        ``pipeline`` is (wall of the stage x cores) / (processor seconds of its analyses), where the
        stage is the call of Snakemake without the time of a dry run; ``pipeline_by_wall`` divides
        by wall seconds, and ``with_snakemake`` includes the start of Snakemake.
    """
    with tempfile.TemporaryDirectory(prefix="pipeline-") as name:
        folder = Path(name)
        study = {
            "grid": {
                "bridge": ["osb1"],
                "skew_deg": [30],
                "gap_mm": list(GAPS_MM[:variants]),
                "friction": [0.5],
            },
            "motions": {
                "suites": ["near"],
                "count": motions,
                "incidence_deg": [0.0],
                "blocks": None,
            },
            "analysis": {"duration_s": duration_s},
        }
        for part in ("Snakefile", "profiles", "workflow", "src", "config", "motions"):
            (folder / part).symlink_to(ROOT / part)
        (folder / "study.json").write_text(json.dumps(study))
        how = (f"-j{cores}", "--quiet", "--")
        make(folder, *how, *BEFORE)
        began_s = time.perf_counter()
        make(folder, *how, "results/demands.parquet")
        call_s = time.perf_counter() - began_s
        began_s = time.perf_counter()
        make(folder, "-n", *how, "results/demands.parquet")
        stage_s = call_s - (time.perf_counter() - began_s)
        rows = pd.read_parquet(folder / "results/demands.parquet")
    cpu_s, wall_s = float(rows["cpu_s"].sum()), float(rows["wall_s"].sum())
    return {
        "pipeline": round(stage_s * cores / cpu_s, 3),
        "pipeline_by_wall": round(stage_s * cores / wall_s, 3),
        "with_snakemake": round(call_s * cores / cpu_s, 3),
        "stage_s": round(stage_s, 1),
        "cpu_s_per_analysis": round(cpu_s / len(rows), 2),
        "analyses": len(rows),
        "motions_per_variant": motions,
        "cores": cores,
    }


if __name__ == "__main__":
    show(pipeline(**vars(options(__doc__, motions=40, variants=2, duration_s=None, cores=2))))
