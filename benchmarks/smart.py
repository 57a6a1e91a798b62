"""Our step loop and opstool's SmartAnalyze over a plain ``analyze(1)`` loop, on one model.

The model is that of `trial_model.py`; solver, integrator, test and step are the same for all three.
Processor time of the loops, taken in turn; then who gets over harder cases. opstool lives in an
environment of its own (requirements-opstool.txt). Prints one JSON object:
    python benchmarks/smart.py [--window-s 8] [--repeats 5]
"""

import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from importlib import import_module
from importlib.metadata import version
from math import ceil, hypot
from typing import Any

import openseespy.opensees as ops
from common import cpu_s, interleaved, options, ratio, show, suite_motion
from trial_model import Trial, end_m

from skewbridge.analysis.recovery import LADDER
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import StepLoop, configure_solver

SETTINGS = AnalysisSettings(dt_s=0.005, contact_dt_s=None, event_dt_s=None)
# opstool's numbers of KrylovNewton, NewtonLineSearch, Broyden: what our ladder has
ALGORITHMS = [40, 20, 70]
# Factor on the motion and stiffness of the gap springs.
HARDER = {"motion x 4": (4.0, 5.0e7), "gaps x 1000": (1.0, 5.0e10)}

type Loop = Callable[[int], bool]


def plain_loop(steps: int) -> bool:
    """Take the steps one by one; return whether all converged."""
    configure_solver(SETTINGS)
    ops.algorithm(*LADDER[0].algorithm)
    ops.integrator(*SETTINGS.integrator_command)
    ops.analysis("Transient", "-noWarnings")
    return all(ops.analyze(1, SETTINGS.dt_s) == 0 for _ in range(steps))


def our_loop(steps: int) -> bool:
    """Take the steps with our step loop; return whether all converged."""
    return StepLoop(None, SETTINGS).run(steps, lambda: None).status == "ok"


def smart_loop(steps: int) -> bool:
    """Take the steps with SmartAnalyze, with the algorithms of our recovery steps."""
    import opstool

    configure_solver(SETTINGS)
    ops.integrator(*SETTINGS.integrator_command)
    smart = opstool.anlys.SmartAnalyze(
        "Transient",
        testType="EnergyIncr",
        testTol=SETTINGS.tolerance_j,
        testIterTimes=SETTINGS.max_iterations,
        tryAlterAlgoTypes=True,
        algoTypes=ALGORITHMS,
        tryLooseTestTol=True,
        looseTestTolTo=0.1,
        minStep=SETTINGS.dt_s / 200,
    )
    try:
        return all(smart.TransientAnalyze(SETTINGS.dt_s) >= 0 for _ in smart.transient_split(steps))
    finally:
        smart.close()


LOOPS: dict[str, Loop] = {"plain": plain_loop, "ours": our_loop, "smart": smart_loop}


def run(loop: Loop, trial: Trial) -> tuple[bool, float, tuple[float, float]]:
    """Return whether a loop got to the end, its processor time, and where the deck is then."""
    trial.build()
    steps = ceil(trial.motion.duration_s / SETTINGS.dt_s - 1e-9)
    done, seconds = cpu_s(partial(loop, steps))
    return done, seconds, end_m()


def import_cost() -> dict[str, float]:
    """Return the memory and time of importing opstool."""
    before_mb, start_s = _peak_mb(), time.process_time()
    import_module("opstool")
    return {
        "ours_resident_mb": before_mb,
        "with_opstool_resident_mb": _peak_mb(),
        "opstool_import_cpu_s": time.process_time() - start_s,
    }


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measure(window_s: float, repeats: int) -> dict[str, Any]:
    """Return the ratios and who got over what."""
    motion = suite_motion("syn002", window_s)
    trial = Trial(motion=motion)
    run(plain_loop, trial)  # what the first run alone pays for
    cost = import_cost()
    ends = {name: run(loop, trial) for name, loop in LOOPS.items()}
    if not all(done for done, _, _ in ends.values()):
        sys.exit("a loop does not get over the easy case")
    works = {name: partial(_seconds, loop, trial) for name, loop in LOOPS.items()}
    seconds = interleaved(works, repeats)
    x_m, y_m = ends["plain"][2]
    harder: dict[str, dict[str, bool]] = {}
    for name, (factor, stiffness) in HARDER.items():
        hard = Trial(motion=motion.scaled(factor), gap_n_per_m=stiffness)
        harder[name] = {program: run(loop, hard)[0] for program, loop in LOOPS.items()}
    return {
        "opstool": version("opstool"),
        "window_s": window_s,
        "ours_over_plain_loop": ratio(seconds["ours"], seconds["plain"]),
        "smart_over_plain_loop": ratio(seconds["smart"], seconds["plain"]),
        "smart_over_ours": ratio(seconds["smart"], seconds["ours"]),
        "last_position_apart_m": {
            name: hypot(x - x_m, y - y_m) for name, (_, _, (x, y)) in ends.items()
        },
        "got_to_the_end": harder,
        **cost,
    }


def _seconds(loop: Loop, trial: Trial) -> float:
    return run(loop, trial)[1]


if __name__ == "__main__":
    given = options(__doc__, window_s=8.0, repeats=5)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # opstool writes a log into the working folder
        with redirect_stdout(sys.stderr):  # SmartAnalyze prints its progress
            found = measure(given.window_s, given.repeats)
    show(found)
