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

import mutated_files

NAMES = tuple(mutated_files.FAMILIES)
RECORDS = NAMES[: NAMES.index("index")]
GROUPS = [NAMES[start::3] for start in range(3)]
SEED = 20261122


@pytest.mark.parametrize(
    ("count", "names"),
    [
        *((34, names) for names in GROUPS),
        (400, RECORDS),
        *(pytest.param(640, names, marks=pytest.mark.slow) for names in GROUPS),
    ],
)
def test_mutant_is_read_or_refused_with_one_message(count, names, tmp_path):
    """A child process reads `count` mutants of each family."""
    script = mutated_files.__file__
    paths = [str(Path(script).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, script, str(count), str(SEED), str(tmp_path), *names],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
    )
    left = [path.name for path in tmp_path.rglob("*") if path.is_file()]
    assert done.returncode == 0, f"ended at {left}: {done.stderr[-2000:]}"
    found = json.loads(done.stdout)
    assert {name: each["faults"] for name, each in found.items() if each["faults"]} == {}
    assert max(each["dearest_s"] for each in found.values()) < mutated_files.CPU_LIMIT_S
    assert all(each["refused"] for each in found.values())
    assert sum(each["taken"] + each["refused"] for each in found.values()) == count * len(names)
