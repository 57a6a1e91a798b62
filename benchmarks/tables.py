"""Processor time and memory of the tables of a study as functions of the number of rows.

`OMP_NUM_THREADS=1 python benchmarks/tables.py 10x100 20x100` takes sizes, variants x motions. Each
runs in a separate process. The result has processor seconds by step, peak memory and the growth
exponents. With several BLAS threads the processor time would include waiting threads.
"""

import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from math import log
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from common import show
from synthetic_rows import arrow_table, synthetic_rows

from skewbridge.demands.columns import demands_for
from skewbridge.demands.tables import join_variants, write_variant
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.effects import effect_tables, median_effects
from skewbridge.fragility.exports import latex_table, paper_table
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.system import system_curves
from skewbridge.report.checks import StudyTables, check_tables
from skewbridge.report.page import explorer_data

_STATES = Path(__file__).parents[1] / "config" / "limit_states.yaml"


def measured(variants: int, motions: int) -> dict[str, Any]:
    """Return the processor seconds of each step in one process, and the peak memory in MB."""
    rows, settings = synthetic_rows(variants, motions), FitSettings()
    states = [state for state in load_limit_states(_STATES) if state.demand in rows]
    names = list(demands_for("effect", rows.columns))
    runs = prepared(rows, [state.demand for state in states], settings).table
    first = fit_models(runs.head(motions), states, settings)
    fit_study(first, states, settings)  # so that imports are not timed
    seconds: dict[str, float] = {}

    def timed[Found](name: str, step: Callable[[], Found]) -> Found:
        start = time.process_time()
        found = step()
        seconds[name] = round(time.process_time() - start, 2)
        sys.stderr.write(f"{variants} x {motions} {name}: {seconds[name]} s\n")
        return found

    timed("collect", lambda: _collect(rows, motions))
    effects = timed("effects", lambda: effect_tables(runs, names, settings)).effects
    models = timed("models", lambda: fit_models(runs, states, settings))
    medians = timed("medians", lambda: median_effects(models, states, settings))
    curves = timed("curves", lambda: fit_study(models, states, settings))
    joint = timed("joint", lambda: joint_table(models, states, settings))
    checked = StudyTables(demands=rows, curves=curves, effects=effects, max_failed_share=1.0)
    timed("check", lambda: check_tables(checked))
    timed("table", lambda: latex_table(paper_table(curves, medians, joint)))
    tables = {"demands": rows, "curves": curves, "effects": effects, "medians": medians}
    timed("explorer", lambda: explorer_data(tables))
    timed("systems", lambda: system_curves(models, states, settings))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return {"variants": variants, "motions": motions, "seconds": seconds, "peak_mb": peak}


def _collect(rows: Any, motions: int) -> None:
    """Write the rows as the workflow does, a variant at a time."""
    table = arrow_table(rows).drop_columns(["suspect"])
    with TemporaryDirectory() as folder:
        paths: list[Path] = []
        for first in range(0, table.num_rows, motions):
            paths.append(Path(folder) / f"{first}.parquet")
            write_variant(table.slice(first, motions).to_pylist(), paths[-1])
        join_variants(paths, Path(folder) / "all.parquet")


def exponents(found: list[dict[str, Any]]) -> dict[str, float]:
    """Return the growth exponent of each step and of their sum, from the first to the last size."""
    first, last = found[0], found[-1]
    grown = log(last["variants"] * last["motions"] / (first["variants"] * first["motions"]))
    both = [each["seconds"] | {"all": sum(each["seconds"].values())} for each in (first, last)]
    return {name: round(log(both[1][name] / both[0][name]) / grown, 2) for name in both[0]}


def main() -> None:
    """Measure the sizes of the command line and print them."""
    sizes = [tuple(map(int, size.split("x"))) for size in sys.argv[1:]]
    found: list[dict[str, Any]] = []
    for variants, motions in sizes:
        with ProcessPoolExecutor(1) as pool:
            found.append(pool.submit(measured, variants, motions).result())
    show({"sizes": found} | ({"exponents": exponents(found)} if len(found) > 1 else {}))


if __name__ == "__main__":
    main()
