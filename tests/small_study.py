"""Commands on a copied tree with the smoke study, and what they leave."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

ROOT = Path(__file__).parents[1]
SNAKEMAKE = Path(sys.executable).parent / "snakemake"
# Measured times may differ between two runs of the same analysis.
TIMES = ["wall_s", "cpu_s"]


def copy_sources(folder: Path) -> Path:
    """Copy the sources into a new folder, without environments and results; return it."""
    left_out = (".git", ".venv", ".uv", ".exports", ".snakemake", "results", ".*_cache")
    ignored = shutil.ignore_patterns(*left_out, ".hypothesis", "__pycache__")
    shutil.copytree(ROOT, folder, ignore=ignored)
    return folder


def command(*arguments, cores=2):
    return [str(SNAKEMAKE), f"-j{cores}", *arguments]


def run(tree, *arguments, over="", check=True, cores=2):
    """Run Snakemake on the small study, with YAML text merged over its configuration."""
    (tree / "over.yaml").write_text(over or "{}")
    given = command("--configfile", "config/smoke.yaml", "over.yaml", *arguments, cores=cores)
    return done(given, tree, check=check)


def done(given, folder, *, check=True, environment=None):
    """Run a command to its end; fail the test with its messages unless it may fail."""
    options = {"capture_output": True, "text": True, "check": False}
    finished = subprocess.run(given, cwd=folder, env=os.environ | (environment or {}), **options)
    if check and finished.returncode != 0:
        pytest.fail(f"{finished.stdout}\n{finished.stderr}")
    return finished


def killed_after_one_analysis(tree, *arguments):
    """Start a study, kill Snakemake after the first analysis, and wait for its children."""
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command(*arguments), cwd=tree, **silent)
    assert wait_for(lambda: (tree / "results/journal").exists() and journal_keys(tree), 300)
    family = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert wait_for(lambda: not any(p.is_running() and p.status() != "zombie" for p in family),
                    60), "children of a killed study go on"  # fmt: skip


def planned_jobs(tree: Path, over: str = "", *targets: str) -> set[str]:
    plan = run(tree, "-n", "--", *targets, over=over)
    return set(re.findall(r"^ *(?:local)?rule (\w+):$", plan.stdout + plan.stderr, re.MULTILINE))


def journal_keys(tree: Path, results: str = "results") -> list[str]:
    return [
        json.loads(line)["run_key"]
        for path in sorted((tree / results / "journal").glob("*.jsonl"))
        for line in path.read_text().splitlines()
        if line.strip().endswith("}")  # not one that is being written
    ]


def wait_for(condition: Callable[[], object], seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while not (is_met := bool(condition())) and time.monotonic() < deadline:
        time.sleep(0.2)
    return is_met
