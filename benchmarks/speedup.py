"""Speed-up of an analysis over the plain one of `plain.py`, and errors of both.

Processor time of plain analyses over that of ours, taken in turn, each from an empty domain; errors
of the peaks of both against ``accuracy: reference``. Finished cases are kept, one JSON line each,
and not repeated while sources and settings stay the same. Prints one JSON object:
    python benchmarks/speedup.py --quick
    python benchmarks/speedup.py [--accuracy default] [--repeats 1] [--error-window-s 10]
"""

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any, Final

from common import RESULTS, Case, cpu_s, interleaved, options, osb1, ratio, spread, suite_motion
from plain import COMMIT, analyse_plain

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import Accuracy, AnalysisSettings, at_accuracy
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.files.digests import canonical, digest_of, engine_digest
from skewbridge.study.journal import open_journal, read_content
from skewbridge.variant.options import ModelOptions

DEMANDS: Final = (
    "column_shear_kn",
    "column_drift_ratio",
    "deck_disp_m",
    "unseating_m",
    "deck_rotation_rad",
    "abutment_passive_m",
)
# The history continues after the drift that counts as collapse, because its peaks are compared.
SETTINGS: Final = AnalysisSettings(collapse_drift_ratio=0.5)


class KeptRows:
    """Rows by key, kept in a journal."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._rows = read_content([path]).rows

    def row(self, key: str, make: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any]:
        """Return the row of a key; make and store it if it is missing."""
        if key not in self._rows:
            self._rows[key] = {"run_key": key, **make()}
            with open_journal(self._path) as journal:
                journal.append(self._rows[key])
        return self._rows[key]


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSet:
    """Cases and repeats of the measurement.

    Attributes:
        motions: Motions of the shipped suite, at their factors.
        places: Skew in degrees and gap in mm.
        window_s: Duration of the strongest part that is timed; None for the whole motion.
        error_window_s: Duration of the strongest part that is compared with the reference.
        repeats: Repeats of each timed pair.
    """

    motions: tuple[str, ...] = ("syn002", "syn008")
    places: tuple[tuple[int, int], ...] = ((30, 25), (60, 51))
    window_s: float | None = 8.0
    error_window_s: float = 8.0
    repeats: int = 2

    def cases(self, window_s: float | None) -> list[Case]:
        """Return every variant under every motion."""
        motions = [suite_motion(name, window_s) for name in self.motions]
        return [
            Case(variant=osb1(*place), motion=motion, window_s=window_s)
            for motion, place in product(motions, self.places)
        ]


QUICK: Final = SpeedSet()
FULL: Final = SpeedSet(
    motions=tuple(f"syn{number:03d}" for number in (*range(1, 10), 11, 12, 14)),
    places=tuple(product((0, 30, 60), (25, 51))),
    window_s=None,
    error_window_s=10.0,
    repeats=1,
)


def measured(
    timed: Case, compared: Case, accuracy: Accuracy, repeats: int, references: KeptRows
) -> dict[str, Any]:
    """Return times of a case, and errors of its peaks against the reference accuracy."""
    settings, options = at_accuracy(SETTINGS, ModelOptions(), accuracy)
    runs: dict[str, Any] = {}

    def plain() -> float:
        runs["plain"] = run = analyse_plain(timed)
        return run.cpu_s

    def ours() -> float:
        runs["ours"], seconds = cpu_s(lambda: _ours(timed, settings, options))
        return seconds

    seconds = interleaved({"plain": plain, "ours": ours}, repeats)
    slow, fast = runs["plain"], runs["ours"]
    facts = ("status", "time_reached_s")
    row = {
        "case": timed.name,
        "compared": compared.name,
        "accuracy": accuracy,
        "cpu_s": seconds,
        "speedup": ratio(seconds["plain"], seconds["ours"]),
        **{name: {fact: getattr(run, fact) for fact in facts} for name, run in runs.items()},
        "failed_steps_of_plain": slow.failed_steps,
    }
    if compared.window_s != timed.window_s:
        slow = analyse_plain(compared)
        fast = _ours(compared, settings, options)
    exact = _reference(compared, references)
    return row | {
        "error_percent": {
            "plain": _errors(slow.demands, exact),
            "ours": _errors(fast.whole_history, exact),
        }
    }


def _reference(case: Case, kept: KeptRows) -> Mapping[str, float]:
    """Return the peaks at the reference accuracy, stored or computed."""
    settings, options = at_accuracy(SETTINGS, ModelOptions(), "reference")

    def make() -> dict[str, Any]:
        found = _ours(case, settings, options).whole_history
        return {"case": case.name, "demands": {name: found[name] for name in DEMANDS}}

    return kept.row(_key(settings, options, case.name), make)["demands"]


def _key(settings: AnalysisSettings, options: ModelOptions, *others: object) -> str:
    numerics = canonical(asdict(settings)), canonical(asdict(options))
    return digest_of(*others, *numerics, engine_digest())


def _ours(case: Case, settings: AnalysisSettings, options: ModelOptions) -> AnalysisResult:
    return analyse(case.variant, Excitation(motion=case.motion), settings, options)


def _errors(found: Mapping[str, float], exact: Mapping[str, float]) -> dict[str, float | None]:
    """Return the errors in percent; None where the reference is zero."""
    return {
        name: 100.0 * (found[name] / exact[name] - 1.0) if exact[name] else None for name in DEMANDS
    }


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the speed-up over all cases, and median and largest size of the errors."""
    alike = [row for row in rows if row["plain"]["status"] == row["ours"]["status"]]
    errors: dict[str, Any] = {}
    for demand in DEMANDS:
        for program in ("plain", "ours"):
            found = [row["error_percent"][program][demand] for row in rows]
            sizes = [abs(value) for value in found if value is not None]
            of_demand = errors.setdefault(demand, {})
            of_demand[program] = {"median": median(sizes), "largest": max(sizes)}
    return {
        # only runs that ended with the same status: an earlier collapse is not a speed-up
        "speedup": spread([row["speedup"]["median"] for row in alike]),
        "cases": len(rows),
        "ended_otherwise": [row["case"] for row in rows if row not in alike],
        "cpu_s_per_record_s": {
            program: median(
                median(row["cpu_s"][program]) / row[program]["time_reached_s"] for row in rows
            )
            for program in ("plain", "ours")
        },
        "failed_steps_of_plain": sum(row["failed_steps_of_plain"] for row in rows),
        "error_percent": errors,
    }


def main() -> None:
    """Measure a set and print the result."""
    given = options(
        __doc__, quick=False, accuracy="default", repeats=0, error_window_s=0.0, out=str(RESULTS)
    )
    base = QUICK if given.quick else FULL
    chosen = replace(
        base,
        error_window_s=given.error_window_s or base.error_window_s,
        repeats=given.repeats or base.repeats,
    )
    store, references = (
        KeptRows(Path(given.out, f"{name}.jsonl")) for name in ("speedup", "references")
    )
    numerics = at_accuracy(SETTINGS, ModelOptions(), given.accuracy)
    rows: list[Mapping[str, Any]] = []
    timed, compared = chosen.cases(chosen.window_s), chosen.cases(chosen.error_window_s)
    for number, pair in enumerate(zip(timed, compared, strict=True), start=1):
        names = [case.name for case in pair]
        key = _key(*numerics, *names, chosen.repeats, COMMIT)
        make = partial(measured, *pair, given.accuracy, chosen.repeats, references)
        rows.append(store.row(key, make))
        speed = rows[-1]["speedup"]["median"]
        sys.stderr.write(f"{number} of {len(timed)}: {rows[-1]['case']}  {speed:.2f}\n")
    sets = asdict(chosen) | {"plain": f"commit {COMMIT}"}
    text = json.dumps({"set": sets, "accuracy": given.accuracy, **summary(rows)}, indent=1)
    sys.stdout.write(text + "\n")


if __name__ == "__main__":
    main()
