"""Efficiency of Slurm jobs of some minutes on a cluster that consists of this host.

It needs what the tests of the cluster need (root, slurm-wlm, munge; tests/cluster) and, by default,
two idle cores for 25 minutes. Prints one JSON object:
    python benchmarks/cluster_jobs.py [--jobs 20] [--job-minutes 2]
"""

import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import pandas as pd
from common import options, show
from study_trees import BEFORE, ROOT, linked_sources, make

CLUSTER = ROOT / "tests/cluster"
NODES = 2  # of one core each
CPU_S = 4.0  # of an analysis of the shipped motions by forecast
SITE = {"SKEWBRIDGE_JOB_CORES": "1", "SKEWBRIDGE_POLL_S": "5"}
SKEWS_DEG, GAPS_MM = (0, 15, 30, 45, 60), (25, 38, 51)


def efficiency(*, jobs: int = 20, job_minutes: float = 2.0) -> dict[str, Any]:
    """Run a study in `jobs` jobs with a forecast of `job_minutes` each and return its times.

    Returns:
        ``efficiency`` is (processor seconds of the analyses) / (cores x wall time from the start of
        Snakemake to the joined table).
    """
    variants = len(SKEWS_DEG) * len(GAPS_MM)
    motions = round(jobs * job_minutes * 60 / CPU_S / variants)
    with tempfile.TemporaryDirectory(prefix="cluster-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        study = {
            "grid": {
                "bridge": ["osb1"],
                "skew_deg": SKEWS_DEG,
                "gap_mm": GAPS_MM,
                "friction": [0.5],
            },
            "motions": {"count": motions},
        }
        linked_sources(folder, study)
        slurm = folder / "slurm"
        subprocess.run([CLUSTER / "start.sh", slurm, "1"], check=True)
        try:
            make(folder, "-j2", "--", *BEFORE, **SITE)
            began_s = time.perf_counter()
            profile = ("--workflow-profile", str(ROOT / "workflow/profiles/slurm"), "--")
            make(folder, *profile, "results/demands.parquet", **SITE)
            wall_s = time.perf_counter() - began_s
        finally:
            subprocess.run([CLUSTER / "stop.sh", slurm], check=True)
        rows = pd.read_parquet(folder / "results/demands.parquet")
        parts = len(list((folder / "results/benchmarks").glob("analyse_*.tsv")))
    cpu_s = float(rows["cpu_s"].sum())
    return {
        "efficiency": cpu_s / (NODES * wall_s),
        "jobs": parts,
        "analyses": len(rows),
        "cpu_s": cpu_s,
        "wall_s": wall_s,
    }


if __name__ == "__main__":
    show(efficiency(**vars(options(__doc__, jobs=20, job_minutes=2.0))))
