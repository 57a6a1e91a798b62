"""The plain analysis: the physics of this package with the numerics of an ordinary script.

It is a fixed commit of this repository, so that later changes of the model do not affect it:
corotational arrays and rigid links, 204 fibers per section, UmfPack, Newton, a test on the norm of
displacements, Houbolt at the paper's step, friction bounds from the last committed state, and
element responses of all contacts in every step. `speedup.py` runs it in a separate process.
"""

import json
import os
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from common import RESULTS, ROOT, Case

COMMIT: Final = "2fb744c"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlainRun:
    """Result of a plain analysis.

    Attributes:
        status: ``ok``, ``collapse``, or ``failed`` if no recovery step converged.
        failed_steps: Steps where Newton failed.
        steps: Steps made.
        iterations: Iterations of the converged regular steps.
        time_reached_s: End of the last step.
        cpu_s: Processor time of the analysis, without imports.
        demands: Peaks as defined in the demands table.
    """

    status: str
    failed_steps: int
    steps: int
    iterations: int
    time_reached_s: float
    cpu_s: float
    demands: dict[str, float]


@cache
def frozen_tree() -> Path:
    """Return a folder with the sources of the plain analysis, extracted from git."""
    folder = RESULTS / f"plain-{COMMIT}"
    if not folder.exists():
        wanted = ("src", "benchmarks", "motions")
        archive = subprocess.run(
            ["git", "-C", str(ROOT), "archive", COMMIT, *wanted], capture_output=True, check=True
        )
        part = folder.with_suffix(".part")
        with tarfile.open(fileobj=BytesIO(archive.stdout)) as files:
            files.extractall(part, filter="data")
        part.rename(folder)
    return folder


def analyse_plain(case: Case) -> PlainRun:
    """Analyse a case with the plain numerics."""
    variant, tree = case.variant, frozen_tree()
    given: dict[str, Any] = {
        "motion": case.motion.motion_id,
        "skew-deg": variant.skew_deg,
        "gap-mm": variant.gap_mm,
        "friction-pct": variant.friction_pct,
    }
    if case.window_s is not None:
        given["window-s"] = case.window_s
    arguments = [f"--{name}={value}" for name, value in given.items()]
    ran = subprocess.run(
        [sys.executable, str(tree / "benchmarks" / "plain.py"), *arguments],
        env=os.environ | {"PYTHONPATH": str(tree / "src"), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(ran.stdout[ran.stdout.index("{") :])
    return PlainRun(**{name: found[name] for name in PlainRun.__dataclass_fields__})
