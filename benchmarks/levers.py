"""Cost and accuracy of the choices of the default numerics.

Each choice is reversed by itself. Measured are the processor time without it over that with all
choices, taken in turn, and the largest change of the peaks. Prints one JSON object:
    python benchmarks/levers.py [--window-s 25] [--repeats 2]
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Final

from common import Case, cpu_s, interleaved, options, osb1, ratio, show, spread, suite_motion
from speedup import DEMANDS, SETTINGS

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions

#: Keys of `analysis` and `model` that reverse a choice.
TAKEN_BACK: Final[Mapping[str, Mapping[str, Any]]] = {
    "tangent of an earlier step": {"reuse_tangent": False},
    "steps of 10 ms far from contact": {"dt_s": 0.005},
    "steps of 5 ms in contact": {"contact_dt_s": 0.0025},
    "friction within 1.5 % of its limit": {"max_friction_error": 0.0075},
    "convergence test of 1e-4 J": {"tolerance_j": 1.0e-8},
    "rigid arms to contacts": {"arrays": "corotational"},
    "120 fibers per section": {"column_fibers": (12, 32, 3)},
    "3 contact points per backwall": {"backwall_points": 5},
    "two elements of pads per deck end": {"pads": "each"},
    "4 elements per span": {"deck_elements_per_span": 8},
}
CASES: Final = (("syn002", 30, 25), ("syn003", 60, 51), ("syn004", 0, 51), ("syn008", 60, 25))


def measured(case: Case, repeats: int) -> dict[str, dict[str, Any]]:
    """Return for one case the cost and the changes of the peaks without each choice."""
    peaks: dict[str, Mapping[str, float]] = {}

    def run(name: str) -> float:
        keys = TAKEN_BACK.get(name, {})
        ours = {key: value for key, value in keys.items() if hasattr(SETTINGS, key)}
        model = {key: value for key, value in keys.items() if key not in ours}
        numerics = replace(SETTINGS, **ours), replace(ModelOptions(), **model)
        excitation = Excitation(motion=case.motion)
        found, seconds = cpu_s(lambda: analyse(case.variant, excitation, *numerics))
        peaks[name] = found.whole_history
        return seconds

    seconds = interleaved({name: partial(run, name) for name in ("all", *TAKEN_BACK)}, repeats)
    return {
        name: {
            "cost": ratio(seconds[name], seconds["all"])["median"],
            "change_percent": {
                demand: 100.0 * abs(peaks[name][demand] / peaks["all"][demand] - 1.0)
                for demand in DEMANDS
                if peaks["all"][demand]
            },
        }
        for name in TAKEN_BACK
    }


def main() -> None:
    """Print the cost over all cases and the largest change of each demand."""
    given = options(__doc__, window_s=25.0, repeats=2)
    found = [
        measured(
            Case(variant=osb1(skew_deg, gap_mm), motion=suite_motion(name, given.window_s)),
            given.repeats,
        )
        for name, skew_deg, gap_mm in CASES
    ]
    show(
        {
            name: {
                "keys": keys,
                "cost": spread([case[name]["cost"] for case in found]),
                "largest_change_percent": {
                    demand: max(case[name]["change_percent"].get(demand, 0.0) for case in found)
                    for demand in DEMANDS
                },
            }
            for name, keys in TAKEN_BACK.items()
        }
    )


if __name__ == "__main__":
    main()
