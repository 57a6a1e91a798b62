"""What the workflow adds to the analyses: wall time of their stage over what the cores could do.

A synthetic study with many motions per variant is run by Snakemake from its motions to its table of
demands. The stage is the jobs that analyse and the one that joins their tables, with the start of
their processes. Prints one JSON object:
    python benchmarks/pipeline.py [--motions 40] [--variants 2] [--duration-s 10] [--cores 2]
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import pandas as pd

ROOT = Path(__file__).parents[1]
GAPS_MM = (25, 51, 38, 64, 12, 76)


def pipeline(
    *, motions: int = 40, variants: int = 2, duration_s: float | None = None, cores: int = 2
) -> dict[str, Any]:
    """Run a study from nothing in a folder of its own and return its times.

    Args:
        motions: Motions of every variant.
        variants: Bridge variants, which differ by their gap; at most six.
        duration_s: Cut the motions; None for whole motions.
        cores: Cores that Snakemake is given.

    Returns:
        ``pipeline`` is (wall of the stage x cores) / (processor seconds of its analyses), and
        ``pipeline_by_wall`` the same over the wall seconds of the analyses, which other work on the
        machine makes as slow as the stage. ``with_snakemake`` counts the start of Snakemake, too.
    """
    with tempfile.TemporaryDirectory(prefix="pipeline-") as name:
        folder = Path(name)
        for part in ("Snakefile", "workflow", "src", "config", "motions"):
            (folder / part).symlink_to(ROOT / part)
        study = {
            "grid": {"skew_deg": [30], "gap_mm": list(GAPS_MM[:variants]), "friction": [0.5]},
            "motions": {"count": motions},
            "analysis": {"duration_s": duration_s},
        }
        (folder / "study.json").write_text(json.dumps(study))
        _snakemake(folder, cores, "results/plan.json", "results/verification/contact_gate.parquet")
        began_s = time.perf_counter()
        _snakemake(folder, cores, "results/demands.parquet")
        call_s = time.perf_counter() - began_s
        stage_s = sum(_seconds(path) for path in (folder / "results/benchmarks").glob("*.tsv"))
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


def _snakemake(folder: Path, cores: int, *targets: str) -> None:
    program = shutil.which("snakemake", path=str(Path(sys.executable).parent)) or "snakemake"
    done = subprocess.run(
        [program, f"-j{cores}", "--quiet", "--configfile", "study.json", "--", *targets],
        cwd=folder,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise SystemExit(f"{done.stdout}\n{done.stderr}")


def _seconds(path: Path) -> float:
    """Return the wall seconds of a job as Snakemake measured them."""
    with path.open(encoding="utf-8") as lines:
        return float(next(csv.DictReader(lines, delimiter="\t"))["s"])


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=int, default=40)
    parser.add_argument("--variants", type=int, default=2)
    parser.add_argument("--duration-s", type=float)
    parser.add_argument("--cores", type=int, default=2)
    found = pipeline(**vars(parser.parse_args()))
    sys.stdout.write(f"{json.dumps(found, indent=1)}\n")


if __name__ == "__main__":
    main()
