"""How much faster an analysis is than the plain one of `plain.py`, and how far both are off.

Processor time of plain analyses over that of ours, taken in turn, each from an empty domain; peaks
of whole histories of both against ``accuracy: reference``. Finished cases are kept, one JSON line
each, and not repeated while sources and settings stay the same. Prints one JSON object:
    python benchmarks/speedup.py --quick
    python benchmarks/speedup.py [--accuracy default] [--repeats 1] [--error-window-s 10]
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any, Final, get_args

from common import RESULTS, Case, cpu_s, interleaved, osb1, ratio, spread, suite_motion
from plain import PLAIN_OPTIONS, PlainRun, analyse_plain, plain_options

from skewbridge.analysis.accuracy import Accuracy, at_accuracy
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
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
# A history that goes on where a column is lost for design: its peaks are compared, not its end.
SETTINGS: Final = AnalysisSettings(collapse_drift_ratio=0.5)


class KeptRows:
    """Rows by key, kept in a journal.

    Args:
        path: The journal.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.rows = read_content([path]).rows
        for row in self.rows.values():
            row.pop("run_key")

    def add(self, key: str, row: Mapping[str, Any]) -> None:
        """Keep the row of a key."""
        self.rows[key] = dict(row)
        with open_journal(self._path) as journal:
            journal.append({"run_key": key, **row})


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSet:
    """Cases and repeats of the measurement.

    Attributes:
        motions: Of the shipped suite, at their factors.
        places: Skew in degrees and gap in mm.
        window_s: Strongest part of the motions that is timed; None for the whole.
        error_window_s: Strongest part that is compared with the reference.
        repeats: Of each timed pair.
    """

    motions: tuple[str, ...]
    places: tuple[tuple[int, int], ...]
    window_s: float | None
    error_window_s: float
    repeats: int

    def cases(self, window_s: float | None) -> list[Case]:
        """Return every variant under every motion."""
        motions = [suite_motion(name, window_s) for name in self.motions]
        return [
            Case(variant=osb1(*place), motion=motion, window_s=window_s)
            for motion, place in product(motions, self.places)
        ]


QUICK: Final = SpeedSet(
    motions=("syn002", "syn008"),
    places=((30, 25), (60, 51)),
    window_s=8.0,
    error_window_s=8.0,
    repeats=2,
)
FULL: Final = SpeedSet(
    motions=tuple(f"syn{number:03d}" for number in (*range(1, 10), 11, 12, 14)),
    places=tuple(product((0, 30, 60), (25, 51))),
    window_s=None,
    error_window_s=10.0,
    repeats=1,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Runs the cases of a set at one accuracy and keeps what they gave."""

    accuracy: Accuracy
    chosen: SpeedSet
    store: KeptRows
    references: KeptRows

    def row(self, timed: Case, compared: Case) -> dict[str, Any]:
        """Return costs and peaks of a case, measured or kept."""
        settings, options = at_accuracy(SETTINGS, ModelOptions(), self.accuracy)
        key = digest_of(
            timed.name,
            compared.name,
            self.chosen.repeats,
            canonical(asdict(settings)),
            canonical(asdict(options)),
            canonical(PLAIN_OPTIONS),
            engine_digest(),
        )
        if (kept := self.store.rows.get(key)) is not None:
            return kept
        runs: dict[str, list[Any]] = {"plain": [], "ours": []}

        def plain() -> float:
            run, seconds = cpu_s(lambda: analyse_plain(timed, SETTINGS, ModelOptions()))
            runs["plain"].append(run)
            return seconds

        def ours() -> float:
            run, seconds = cpu_s(lambda: _ours(timed, settings, options))
            runs["ours"].append(run)
            return seconds

        seconds = interleaved({"plain": plain, "ours": ours}, self.chosen.repeats)
        slow, fast = runs["plain"][-1], runs["ours"][-1]
        row = {
            "case": timed.name,
            "compared": compared.name,
            "accuracy": self.accuracy,
            "seconds_of_motion": fast.duration_s,
            "cpu_s": seconds,
            "speedup": ratio(seconds["plain"], seconds["ours"]),
            "plain": _plain_facts(slow),
            "ours": _our_facts(fast),
            "ends_alike": slow.status == fast.status,
        }
        if compared.window_s != timed.window_s:
            slow = analyse_plain(compared, SETTINGS, ModelOptions())
            fast = _ours(compared, settings, options)
        exact = self.reference(compared)
        row["error_percent"] = {
            "plain": _errors(slow.demands, exact),
            "ours": _errors(fast.whole_history, exact),
        }
        self.store.add(key, row)
        return row

    def reference(self, case: Case) -> Mapping[str, float]:
        """Return the peaks of the reference, computed or kept."""
        settings, options = at_accuracy(SETTINGS, ModelOptions(), "reference")
        parts = (case.name, canonical(asdict(settings)), canonical(asdict(options)))
        key = digest_of(*parts, engine_digest())
        if (kept := self.references.rows.get(key)) is not None:
            return kept["demands"]
        found = _ours(case, settings, options).whole_history
        demands = {name: found[name] for name in DEMANDS}
        self.references.add(key, {"case": case.name, "demands": demands})
        return demands


def _ours(case: Case, settings: AnalysisSettings, options: ModelOptions) -> AnalysisResult:
    return analyse(case.variant, Excitation(motion=case.motion), settings, options)


def _errors(found: Mapping[str, float], exact: Mapping[str, float]) -> dict[str, float | None]:
    """Return the changes in percent; none where a demand is absent from the reference."""
    return {
        name: 100.0 * (found[name] / exact[name] - 1.0) if exact[name] else None for name in DEMANDS
    }


def _plain_facts(run: PlainRun) -> dict[str, Any]:
    facts = ("status", "time_reached_s", "steps", "iterations", "failed_steps")
    return {name: getattr(run, name) for name in facts}


def _our_facts(run: AnalysisResult) -> dict[str, Any]:
    facts = ("status", "time_reached_s", "substeps", "iterations", "failed_attempts")
    return {name: getattr(run, name) for name in facts}


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the speed-up over all cases, and median and worst size of the errors."""
    errors: dict[str, Any] = {}
    for demand in DEMANDS:
        for program in ("plain", "ours"):
            found = [row["error_percent"][program][demand] for row in rows]
            sizes = [abs(value) for value in found if value is not None]
            of_demand = errors.setdefault(demand, {})
            of_demand[program] = {"median": median(sizes), "largest": max(sizes)}
    return {
        # of whole runs that ended at the same time: a collapse found earlier is no speed
        "speedup": spread([r["speedup"]["median"] for r in rows if r["ends_alike"]]),
        "cases": len(rows),
        "ended_otherwise": [row["case"] for row in rows if not row["ends_alike"]],
        "cpu_s_per_record_s": {
            program: median(
                median(row["cpu_s"][program]) / row[program]["time_reached_s"] for row in rows
            )
            for program in ("plain", "ours")
        },
        "failed_steps_of_plain": sum(row["plain"]["failed_steps"] for row in rows),
        "error_percent": errors,
    }


def main() -> None:
    """Measure a set and print the result."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="four cases of 8 s")
    parser.add_argument("--accuracy", choices=get_args(Accuracy.__value__), default="default")
    parser.add_argument("--repeats", type=int)
    parser.add_argument("--error-window-s", type=float)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    base = QUICK if given.quick else FULL
    chosen = SpeedSet(
        motions=base.motions,
        places=base.places,
        window_s=base.window_s,
        error_window_s=given.error_window_s or base.error_window_s,
        repeats=given.repeats or base.repeats,
    )
    bench = Bench(
        accuracy=given.accuracy,
        chosen=chosen,
        store=KeptRows(given.out / "speedup.jsonl"),
        references=KeptRows(given.out / "references.jsonl"),
    )
    rows: list[dict[str, Any]] = []
    timed, compared = chosen.cases(chosen.window_s), chosen.cases(chosen.error_window_s)
    for number, pair in enumerate(zip(timed, compared, strict=True), start=1):
        rows.append(bench.row(*pair))
        speed = rows[-1]["speedup"]["median"]
        sys.stderr.write(f"{number} of {len(timed)}: {rows[-1]['case']}  {speed:.2f}\n")
    sets = {
        "motions": chosen.motions,
        "skew_and_gap": chosen.places,
        "timed_window_s": chosen.window_s,
        "compared_window_s": chosen.error_window_s,
        "plain_options": {
            name: getattr(plain_options(ModelOptions()), name) for name in PLAIN_OPTIONS
        },
    }
    text = json.dumps({"set": sets, "accuracy": given.accuracy, **summary(rows)}, indent=1)
    sys.stdout.write(text + "\n")


if __name__ == "__main__":
    main()
