"""Throughput of two workers over one, and memory of a worker over hundreds of analyses.

Throughput is measured in wall time, for the same analyses in loky pools of one and two workers in
turn; it is meaningful only on an idle machine. The processor time per analysis with two workers
over that with one shows the cost of sharing even on a busy machine; 2 / this ratio estimates the
throughput of an idle machine. Memory is the resident set of one process, read after every 20
analyses of changing variants. Prints one JSON object:
    python benchmarks/workers.py [--analyses 8] [--repeats 3] [--memory-analyses 320]
"""

import os
import resource
import sys
import time
from functools import partial
from statistics import linear_regression
from typing import Any

import psutil
from common import Case, cpu_s, options, osb1, ratio, show, suite_motion
from joblib.externals.loky import ProcessPoolExecutor

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.study.processes import hush_exit_message
from skewbridge.variant.options import ModelOptions

WORKERS = (1, 2)
WARM_UP = 20  # analyses between two readings of the memory
SHORT_S = 2.5
MB = 2.0**20


def one(case: Case) -> float:
    """Analyse a case; return its processor time."""
    hush_exit_message()
    excitation = Excitation(motion=case.motion)
    return cpu_s(lambda: analyse(case.variant, excitation, AnalysisSettings(), ModelOptions()))[1]


def throughput(case: Case, analyses: int, repeats: int) -> dict[str, Any]:
    """Return the ratios of throughput and of processor time per analysis, two workers over one."""
    pools = {number: ProcessPoolExecutor(max_workers=number) for number in WORKERS}
    walls: dict[int, list[float]] = {number: [] for number in WORKERS}
    cpus: dict[int, list[float]] = {number: [] for number in WORKERS}
    for repeat in range(repeats + 1):
        for number, pool in pools.items():
            start_s = time.perf_counter()
            seconds = list(pool.map(one, [case] * analyses))
            if repeat:  # the first repeat starts the workers and is not counted
                walls[number].append(time.perf_counter() - start_s)
                cpus[number].append(sum(seconds))
    for pool in pools.values():
        pool.shutdown()
    return {
        "case": case.name,
        "analyses": analyses,
        "throughput_two_over_one": ratio(walls[1], walls[2]),
        "cpu_per_analysis_two_over_one": ratio(cpus[2], cpus[1]),
        "load_average": os.getloadavg()[0],
    }


def memory(analyses: int) -> dict[str, Any]:
    """Return the memory of a new worker and its growth."""
    with ProcessPoolExecutor(max_workers=1) as pool:
        return pool.submit(partial(_memory, analyses)).result()


def _memory(analyses: int) -> dict[str, Any]:
    motion = suite_motion("syn002", SHORT_S)
    variants = [osb1(skew_deg, gap_mm) for skew_deg in (0, 30, 60) for gap_mm in (25, 51)]
    resident_mb: dict[int, float] = {}
    for number in range(analyses):
        one(Case(variant=variants[number % len(variants)], motion=motion, window_s=SHORT_S))
        if (number + 1) % WARM_UP == 0:
            resident_mb[number + 1] = psutil.Process().memory_info().rss / MB
    # readings fluctuate: growth is the slope of a line through all of them
    line = linear_regression([*resident_mb], [*resident_mb.values()])
    return {
        "analyses": analyses,
        "window_s": SHORT_S,
        "resident_mb_after": resident_mb,
        "growth_mb_per_100": 100.0 * line.slope,
        "largest_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def main() -> None:
    """Print throughput and memory."""
    given = options(__doc__, analyses=8, repeats=3, memory_analyses=320, window_s=8.0)
    if given.memory_analyses < 2 * WARM_UP:
        sys.exit(f"--memory-analyses must be at least {2 * WARM_UP}")
    motion = suite_motion("syn002", given.window_s)
    case = Case(variant=osb1(30, 51), motion=motion, window_s=given.window_s)
    parallel = throughput(case, given.analyses, given.repeats)
    show({"parallel": parallel, "memory": memory(given.memory_analyses)})


if __name__ == "__main__":
    main()
