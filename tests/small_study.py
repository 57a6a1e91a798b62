"""Commands on a copied tree with the smoke study, and what they leave."""

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

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


def command(*arguments: str, cores: int = 2) -> list[str]:
    return [str(SNAKEMAKE), f"-j{cores}", *arguments]


def run(
    tree: Path, *arguments: str, over: str = "", check: bool = True, cores: int = 2
) -> subprocess.CompletedProcess[str]:
    """Run Snakemake on the small study, with YAML text merged over its configuration."""
    (tree / "over.yaml").write_text(over or "{}")
    configuration = ["--configfile", "config/smoke.yaml", "over.yaml"]
    done = subprocess.run(
        command(*configuration, *arguments, cores=cores),
        cwd=tree,
        capture_output=True,
        text=True,
        check=False,
    )
    if check and done.returncode != 0:
        pytest.fail(f"{done.stdout}\n{done.stderr}")
    return done


def planned_jobs(tree: Path, over: str = "", *targets: str) -> set[str]:
    """Names of the rules that a dry run would execute."""
    text = run(tree, "-n", "--", *targets, over=over)
    lines = (text.stdout + text.stderr).splitlines()
    found = [line.split() for line in lines]
    return {
        words[1].rstrip(":")
        for words in found
        if len(words) == 2 and words[0] in {"rule", "localrule"}
    }


def journal_keys(tree: Path, results: str = "results") -> list[str]:
    return [
        json.loads(line)["run_key"]
        for path in sorted((tree / results / "journal").glob("*.jsonl"))
        for line in path.read_text().splitlines()
        if line.strip().endswith("}")  # not one that is being written
    ]


def wait_for(condition: Callable[[], object], seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.2)
    return False
