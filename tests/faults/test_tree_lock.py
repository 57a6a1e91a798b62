"""One study at a time in a tree; what a killed one leaves behind stops nothing."""

import subprocess
import sys
from pathlib import Path

HOLD = (
    "import sys, time; from pathlib import Path;"
    "from skewbridge.errors import InputError; from skewbridge.study.processes import hold_tree\n"
    "try:\n    hold_tree(Path(sys.argv[1]))\n"
    "except InputError as error:\n    sys.exit(str(error))\n"
    "print('held', flush=True); sys.stdin.read()"
)


def holder(folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_the_lock_ends_with_its_process(tmp_path: Path) -> None:
    folder = tmp_path / ".snakemake"
    first = holder(folder)
    assert first.stdout is not None
    assert first.stdout.readline() == "held\n"
    second = holder(folder)
    _, said = second.communicate()
    assert second.returncode == 1
    assert f"another study is running in {tmp_path} (process {first.pid})" in said
    assert "Traceback" not in said
    first.kill()
    first.wait()
    third = holder(folder)
    assert third.stdout is not None
    assert third.stdout.readline() == "held\n"
    third.communicate()
