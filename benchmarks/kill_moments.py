"""Kill the whole small study at random moments and resume it with the same command.

usage: python benchmarks/kill_moments.py [--moments 10] [--seed 1] [--duration-s 10] --out FOLDER

Each time in a fresh copy of the tree: all processes of the study get SIGKILL (or with --signal INT
what Ctrl-C sends) at a random moment, then the study is started again. It must complete, repeat no
analysis that had finished, give the tables of an undisturbed run, and leave no process alive
5 s after the kill. Exits with 1 where one of these does not hold.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import uuid
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd
import psutil
from study_trees import TIMES, copy_sources

from skewbridge.study.journal import JournalContent, read_content

SNAKEMAKE = Path(sys.executable).parent / "snakemake"
CORES = 2
GRACE_S = 5.0
MARK = "SKEWBRIDGE_KILL_MOMENT"
#: What is forecast from measured times differs like them.
TIMED = [*TIMES, "more_core_hours"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Result of a study that was ended at one moment and resumed."""

    at_s: float
    finished_before: int
    finished_repeated: int
    alive_after_grace: int
    ended_after_s: float
    completed: bool
    equal: bool

    @property
    def holds(self) -> bool:
        """Whether the resumed study is complete, equal and repeated nothing."""
        return (
            self.completed
            and self.equal
            and not self.alive_after_grace
            and not self.finished_repeated
        )


def copied_sources(folder: Path, duration_s: float) -> Path:
    """Copy the sources once, with motions cut to a length: they may be edited meanwhile."""
    copy_sources(folder)
    smoke = folder / "config/smoke.yaml"
    smoke.write_text(smoke.read_text().replace("10.0", f"{duration_s:g}"))
    return folder


def start(tree: Path, mark: str) -> subprocess.Popen[bytes]:
    """Start the small study in a new process group."""
    with (tree / "study.log").open("ab") as log:
        return subprocess.Popen(
            [SNAKEMAKE, f"-j{CORES}", "--configfile", "config/smoke.yaml"],
            cwd=tree,
            stdout=log,
            stderr=log,
            start_new_session=True,
            env=os.environ | {MARK: mark},
        )


def alive(mark: str) -> list[psutil.Process]:
    """Return the processes of a study, whatever group they are in."""
    found: list[psutil.Process] = []
    for process in psutil.process_iter():
        try:
            if process.environ().get(MARK) == mark and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except psutil.Error:
            continue
    return found


def finished(tree: Path) -> JournalContent:
    """Return what the journals hold, wherever the study writes its results."""
    return read_content(sorted((tree / "results").rglob("journal/*.jsonl")))


def equal(tree: Path, reference: Path) -> bool:
    """Return whether all tables are those of the reference, but for times."""
    for path in sorted((reference / "results").rglob("*.parquet")):
        expected = pd.read_parquet(path)
        found = pd.read_parquet(tree / path.relative_to(reference))
        times = [name for name in TIMED if name in expected]
        if not found.drop(columns=times).equals(expected.drop(columns=times)):
            sys.stderr.write(f"{path} differs\n")
            return False
    return True


def ended_at(tree: Path, reference: Path, at_s: float, sent: signal.Signals) -> Outcome:
    """End the study after `at_s` seconds, resume it and compare."""
    mark = uuid.uuid4().hex
    process = start(tree, mark)
    time.sleep(at_s)
    os.killpg(process.pid, sent)
    began_s = time.monotonic()
    while alive(mark) and time.monotonic() - began_s < GRACE_S:
        process.poll()
        time.sleep(0.1)
    ended_after_s = time.monotonic() - began_s
    left = alive(mark)
    for each in left:
        each.kill()
    process.wait()
    before = finished(tree)
    again = start(tree, mark)
    completed = again.wait() == 0
    return Outcome(
        at_s=round(at_s, 1),
        finished_before=len(before.rows),
        finished_repeated=finished(tree).repeated,
        alive_after_grace=len(left),
        ended_after_s=round(ended_after_s, 1),
        completed=completed,
        equal=completed and equal(tree, reference),
    )


def main() -> None:
    """Run the study undisturbed, then with each of the moments."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--moments", type=int, default=10)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--duration-s", type=float, default=10.0)
    asked.add_argument("--signal", choices=["KILL", "INT"], default="KILL")
    asked.add_argument("--out", type=Path, required=True)
    chosen = asked.parse_args()
    chosen.out.mkdir(parents=True)
    sources = copied_sources(chosen.out / "sources", chosen.duration_s)
    reference = Path(shutil.copytree(sources, chosen.out / "reference"))
    began_s = time.monotonic()
    if start(reference, "reference").wait() != 0:
        sys.exit("the undisturbed study failed: see reference/study.log")
    whole_s = time.monotonic() - began_s
    draw = random.Random(chosen.seed)
    sent = signal.Signals[f"SIG{chosen.signal}"]
    outcomes: list[Outcome] = []
    for number in range(chosen.moments):
        tree = Path(shutil.copytree(sources, chosen.out / str(number)))
        outcomes.append(ended_at(tree, reference, draw.uniform(0.02, 0.98) * whole_s, sent))
        sys.stdout.write(f"{json.dumps(asdict(outcomes[-1]))}\n")
        sys.stdout.flush()
    held = sum(each.holds for each in outcomes)
    sys.stdout.write(f"{held} of {len(outcomes)} moments hold; undisturbed {whole_s:.0f} s\n")
    sys.exit(held != len(outcomes))


if __name__ == "__main__":
    main()
