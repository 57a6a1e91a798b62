"""What Slurm and the workflow add to jobs of some minutes: efficiency on a cluster of this host.

It needs what the tests of the cluster need (root, slurm-wlm, munge; tests/cluster) and, by default,
two idle cores for 25 minutes. Prints one JSON object:
    python benchmarks/cluster_jobs.py [--jobs 20] [--job-minutes 2]
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import pandas as pd

ROOT = Path(__file__).parents[1]
CLUSTER = ROOT / "tests/cluster"
NODES = 2  # of one core each
CPU_S = 4.0  # of an analysis of the shipped motions by forecast
SKEWS_DEG, GAPS_MM = (0, 15, 30, 45, 60), (25, 38, 51)
BEFORE = ("results/plan.json", "results/verification/contact_gate.parquet")


def efficiency(*, jobs: int = 20, job_minutes: float = 2.0) -> dict[str, Any]:
    """Run a study in so many jobs of so many minutes by forecast and return its times.

    Returns:
        ``efficiency`` is (processor seconds of the analyses) / (cores x wall time from the start of
        Snakemake to the joined table).
    """
    variants = len(SKEWS_DEG) * len(GAPS_MM)
    motions = round(jobs * job_minutes * 60 / CPU_S / variants)
    with tempfile.TemporaryDirectory(prefix="cluster-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        for part in ("Snakefile", "workflow", "src", "config", "motions"):
            (folder / part).symlink_to(ROOT / part)
        study = {
            "grid": {
                "bridge": ["osb1"],
                "skew_deg": SKEWS_DEG,
                "gap_mm": GAPS_MM,
                "friction": [0.5],
            },
            "motions": {"count": motions},
            "batches": {"cpu_hours": variants * motions * CPU_S / 3600 / jobs},
        }
        (folder / "study.json").write_text(json.dumps(study))
        slurm = folder / "slurm"
        subprocess.run([CLUSTER / "start.sh", slurm, "1"], check=True)
        try:
            _snakemake(folder, ["-j2"], *BEFORE)
            began_s = time.perf_counter()
            profile = ["--workflow-profile", str(ROOT / "workflow/profiles/slurm")]
            _snakemake(folder, profile, "results/demands.parquet")
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


def _snakemake(folder: Path, how: list[str], *targets: str) -> None:
    site = {"SKEWBRIDGE_JOB_CORES": "1", "SKEWBRIDGE_POLL_S": "5"}
    subprocess.run(
        [sys.executable, "-m", "snakemake", *how, "--configfile", "study.json", "--", *targets],
        cwd=folder,
        check=True,
        stdout=sys.stderr,
        env=os.environ | site,
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=20)
    parser.add_argument("--job-minutes", type=float, default=2.0)
    chosen = parser.parse_args()
    json.dump(efficiency(jobs=chosen.jobs, job_minutes=chosen.job_minutes), sys.stdout, indent=1)
