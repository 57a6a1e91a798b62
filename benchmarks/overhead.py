"""Cost of everything around the solver: analyses of the default study over their bare commands.

The OpenSees commands of an analysis are recorded and run again as a script: the same model, calls
of `analyze`, switches of the algorithm and updates of friction bounds, so the equations are equal,
but no recorders, readings, step control and demands. Results are median ratios of processor times,
taken in turn. Prints one JSON object:
    python benchmarks/overhead.py [--motions 3] [--repeats 5]

The cases are one variant of each bridge under motions at evenly spaced quantiles of PGV.
"""

from collections.abc import Callable, Sequence
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any, Final
from unittest.mock import patch

import numpy as np
import openseespy.opensees as ops
from common import ROOT, cpu_s, interleaved, options, ratio, show, spread

from skewbridge.analysis.model_script import recording
from skewbridge.files.text import read_mapping
from skewbridge.study.analyses import StudySetup, sampled
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import Task

CONFIGURATION: Final = ROOT / "config" / "config.yaml"
VARIANTS: Final = ("osb1_cf_skew30_gap051_mu050", "osb1_fixed_era1_cf_skew30_gap025_mu050")


def tasks_of_study(motions: int) -> list[Task]:
    """Return analyses of the default study, as its workflow runs them."""
    with TemporaryDirectory() as results:
        study = parse_config({**read_mapping(CONFIGURATION), "results": results})
        prepare_motions(study)
        setup = StudySetup.of(study)
    return [task for slug in VARIANTS for task in sampled(setup.planned_tasks(slug), motions)]


def last_disp_m(work: Callable[[], object]) -> np.ndarray:
    """Run an analysis; return the displacements of its nodes before the domain is wiped."""
    states: list[list[list[float]]] = []

    def keep(wipe: Callable[[], None] = ops.wipe) -> None:
        states.append([ops.nodeDisp(node) for node in ops.getNodeTags() or ()])
        wipe()

    with patch.object(ops, "wipe", keep):
        work()
    return np.array(states[-1])


def bare_script(commands: Sequence[str]) -> Callable[[], None]:
    """Return a function that runs recorded commands."""
    return partial(exec, compile("\n".join(commands), "bare analysis", "exec"), {"ops": ops})


def measure(task: Task, repeats: int) -> dict[str, Any]:
    """Return the ratio of processor times of one analysis."""
    with recording() as commands:
        ours_m = last_disp_m(task.analyse)
    bare = bare_script(commands)
    difference_m = float(np.abs(last_disp_m(bare) - ours_m).max())
    works = {"bare": lambda: cpu_s(bare)[1], "ours": lambda: cpu_s(task.analyse)[1]}
    seconds = interleaved(works, repeats)
    return {
        "case": f"{task.variant.slug} {task.motion.motion.motion_id}",
        "overhead": ratio(seconds["ours"], seconds["bare"]),
        "bare_cpu_s": spread(seconds["bare"]),
        # only rounding: both solve the same equations
        "largest_difference_of_last_disp_m": difference_m,
    }


def main() -> None:
    """Print the ratio over all cases, and the cases."""
    given = options(__doc__, motions=3, repeats=5)
    cases = [measure(task, given.repeats) for task in tasks_of_study(given.motions)]
    show({"overhead": spread([case["overhead"]["median"] for case in cases]), "cases": cases})


if __name__ == "__main__":
    main()
