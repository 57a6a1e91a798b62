"""Cost of everything around the solver: our analysis compared with one bare ``analyze(n, dt)``.

Both run the same model from an empty domain at equal fixed steps, with friction 0, so that the
equations are the same although ours sets friction bounds after every step and the bare one never
does. Results are median ratios of processor times, taken in turn. Prints one JSON object:
    python benchmarks/overhead.py [--motions syn005 syn001] [--window-s 8] [--repeats 5]

A failed step ends the bare analysis, so the first given motion without a failed step is used.
The free vibration to rest after the motion is left out; building and dead load are included.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import openseespy.opensees as ops
from common import Case, cpu_s, interleaved, options, osb1, ratio, show, spread, suite_motion

from skewbridge.analysis import transient
from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.analysis.recovery import RECOVERY_STEPS
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import configure_solver, solver_log
from skewbridge.analysis.transient import AnalysisResult
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions

SETTINGS = AnalysisSettings(
    contact_dt_s=None, event_dt_s=None, reuse_tangent=False, collapse_drift_ratio=0.5
)


def bare(case: Case, settings: AnalysisSettings) -> float:
    """Run the model without reading results; return the final deck displacement along x (m)."""
    ground = GroundInput(Excitation(motion=case.motion), settings)
    with solver_log(None), domain():
        model = build(case.variant, ModelOptions())
        apply_rayleigh(model)
        ground.apply(model.tags)
        start_m = ops.nodeDisp(model.deck_centre_node, 1)
        configure_solver(settings)
        ops.algorithm(*RECOVERY_STEPS[0].algorithm)
        ops.integrator(*settings.integrator_command)
        ops.analysis("Transient", "-noWarnings")
        if ops.analyze(ground.steps, settings.dt_s) != 0:
            sys.exit("a step of the bare analysis failed: choose a weaker motion")
        return float(ops.nodeDisp(model.deck_centre_node, 1)) - start_m


def ours(
    case: Case, settings: AnalysisSettings, *, histories: bool = False
) -> tuple[AnalysisResult, float]:
    """Run our analysis; return its result and the processor time (s) of the final vibration."""
    rest_s: list[float] = []

    def timed[**P, R](work: Callable[P, R]) -> Callable[P, R]:
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            start_s = time.process_time()
            found = work(*args, **kwargs)
            rest_s.append(time.process_time() - start_s)
            return found

        return call

    with patch.object(transient, "drifts_at_rest", timed(transient.drifts_at_rest)):
        result = transient.analyse(
            case.variant,
            Excitation(motion=case.motion),
            settings,
            ModelOptions(),
            histories=histories,
        )
    return result, sum(rest_s)


def measure(case: Case, repeats: int) -> dict[str, Any] | None:
    """Return the ratios, or None if a step fails."""
    result, _ = ours(case, SETTINGS, histories=True)
    if result.effort.failures:
        return None
    end_m, histories = bare(case, SETTINGS), result.histories
    if histories is None:
        sys.exit("the analysis has no histories")

    def our_time(settings: AnalysisSettings) -> float:
        (_, rest_s), seconds = cpu_s(lambda: ours(case, settings))
        return seconds - rest_s

    works = {
        "bare": lambda: cpu_s(lambda: bare(case, SETTINGS))[1],
        "ours": lambda: our_time(SETTINGS),
        "without energy": lambda: our_time(replace(SETTINGS, energy=False)),
    }
    seconds = interleaved(works, repeats)
    return {
        "case": case.name,
        "dt_s": SETTINGS.dt_s,
        "overhead": ratio(seconds["ours"], seconds["bare"]),
        "without_energy": ratio(seconds["without energy"], seconds["bare"]),
        "bare_cpu_s": spread(seconds["bare"]),
        # only rounding: both solve the same equations
        "difference_of_last_deck_ux_m": abs(float(histories["deck_ux_m"][-1]) - end_m),
    }


def main() -> None:
    """Print the ratios under the first motion without a failed step."""
    given = options(
        __doc__, motions=("syn005", "syn001", "syn008", "syn012"), window_s=8.0, repeats=5
    )
    for name in given.motions:
        motion = suite_motion(name, given.window_s)
        case = Case(variant=osb1(30, 51, friction_pct=0), motion=motion, window_s=given.window_s)
        if (found := measure(case, given.repeats)) is not None:
            show(found)
            return
    sys.exit("a step failed under every motion")


if __name__ == "__main__":
    main()
