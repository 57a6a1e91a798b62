"""Mutated input files of every kind are read, or refused with one message; never a traceback.

Each group of readers runs in a child that may use 5 CPU-seconds for a file and 500 MB of memory
more than the program itself.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import mutants

RECORDS = ("at2", "v2", "knet", "columns", "three_columns", "values")
GROUPS = (
    (*RECORDS, "index"),
    ("config", "limit_states", "bridge", "contact", "deck", "path"),
    ("fit_cloud", "fit_stripes", "fit_csv", "fit_parquet"),
)
SEED = 20261122


def read_mutants(count: int, names: tuple[str, ...], folder: Path) -> int:
    """Let a child process read `count` mutants of each family; return the number read."""
    command = [sys.executable, mutants.__file__, str(count), str(SEED), str(folder), *names]
    paths = [str(Path(mutants.__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
    )
    left = [path.name for path in folder.rglob("*") if path.is_file()]
    assert done.returncode == 0, f"ended at {left}: {done.stderr[-2000:]}"
    found = json.loads(done.stdout)
    assert {name: told["faults"] for name, told in found.items() if told["faults"]} == {}
    assert max(told["dearest_s"] for told in found.values()) < mutants.CPU_LIMIT_S
    assert all(told["refused"] for told in found.values())
    return sum(told["taken"] + told["refused"] for told in found.values())


def test_every_family_is_in_a_group() -> None:
    assert sorted(name for group in GROUPS for name in group) == sorted(mutants.FAMILIES)


@pytest.mark.parametrize("names", GROUPS, ids=lambda names: names[0])
def test_mutant_is_read_or_refused_with_one_message(names: tuple[str, ...], tmp_path: Path) -> None:
    assert read_mutants(34, names, tmp_path) == 34 * len(names)


def test_more_mutants_of_records(tmp_path: Path) -> None:
    assert read_mutants(400, RECORDS, tmp_path) == 400 * len(RECORDS)


@pytest.mark.slow
@pytest.mark.parametrize("names", GROUPS, ids=lambda names: names[0])
def test_ten_thousand_mutants(names: tuple[str, ...], tmp_path: Path) -> None:
    assert read_mutants(640, names, tmp_path) == 640 * len(names)
