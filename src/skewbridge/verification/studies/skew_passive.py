"""Passive force of skewed walls against tests at skews of 15 to 45 degrees.

A slow push of the built abutment normal to its wall gives strength, initial stiffness and closure
at full strength, without the force of the pads. Each row of `skew_passive.csv` is a test:
``strength`` is the peak force as a share of that at skew 0, ``peak_closure`` the closure at the
peak / wall height. The sources report without numbers that the initial stiffness is the same at all
skews. No test exists at larger skews.
"""

from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.trace import Series
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.units import MM
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import Panel, Study, drawn
from skewbridge.verification.statements import records_in
from skewbridge.verification.studies.paper_runs import paper_variant

TESTS: Final = tuple(records_in(Path(__file__).parents[1] / "skew_passive.csv"))
BRIDGE: Final = "osb1"
# of the strength or stiffness at skew 0; two tests at 45 degrees differ by 0.11
TOLERANCE: Final = 0.10
CLOSURE_TOLERANCE: Final = 0.01  # of the wall height
END_M: Final = 0.08
SMALL_M: Final = 0.2e-3  # closure of the initial stiffness, 0.01 % of the wall height
FULL: Final = 0.995  # share of the force at the end that counts as full strength


class WallPush(NamedTuple):
    """Closures (m) and forces (N) of a wall pushed normal to its face, shape (n,)."""

    closure_m: Series
    force_n: Series

    @property
    def stiffness_n_per_m(self) -> float:
        """Secant stiffness at a small closure."""
        return float(np.interp(SMALL_M, self.closure_m, self.force_n)) / SMALL_M

    @property
    def peak_closure_m(self) -> float:
        """Smallest closure at full strength."""
        return float(self.closure_m[np.argmax(self.force_n >= FULL * self.force_n[-1])])


def push_wall(skew_deg: int, options: ModelOptions) -> WallPush:
    """Push the wall of an abutment without a gap; a pull away from it gives the pad forces."""
    variant = paper_variant(bridge=BRIDGE, skew_deg=skew_deg, gap_mm=0)
    push, pull = (
        push_abutment(variant, options, angle_deg=angle_deg, max_disp_m=END_M, steps=800)
        for angle_deg in (skew_deg, skew_deg + 180)
    )
    if not (push.is_complete and pull.is_complete):
        raise RuntimeError(f"the push of the wall at skew {skew_deg} stopped early")
    pads_n = np.interp(push.disp_m, pull.disp_m, pull.force_n)
    return WallPush(push.disp_m, push.force_n - pads_n)


def run(study: Study) -> None:
    """Compare strength, stiffness and closure at full strength with the tests."""
    height_m = load_bridge(BRIDGE).abutment.wall_height_m
    panels: list[Panel] = []
    for curve in ("hyperbolic", "sdc"):
        # a push normal to the wall never closes keys square to it
        options = ModelOptions(backfill=curve, key_frame="skewed")
        skews = sorted({0, *(int(row["skew_deg"]) for row in TESTS)})
        pushes = {skew: push_wall(skew, options) for skew in skews}
        straight = pushes[0]
        for row in TESTS:
            pushed, source = pushes[int(row["skew_deg"])], row["source"]
            name = f"{curve}, skew {row['skew_deg']}, {row['test']}"
            share = pushed.force_n[-1] / straight.force_n[-1]
            if row["strength"]:
                found = share, float(row["strength"]), TOLERANCE
                study.absolute(f"{name}: strength / that at skew 0", *found, source)
            else:
                study.holds(f"{name}: weaker than at skew 0", truth=share < 1.0, source=source)
            if curve == "hyperbolic":  # a bilinear curve that keeps its stiffness peaks earlier
                closure = pushed.peak_closure_m / height_m, float(row["peak_closure"])
                # the field tests reach their peaks later at skew 15 to 45 than at skew 0
                limit = None if row["test"].startswith("field") else CLOSURE_TOLERANCE
                study.absolute(f"{name}: closure at the peak / height", *closure, limit, source)
        for skew in skews[1:]:
            ratio = pushes[skew].stiffness_n_per_m / straight.stiffness_n_per_m
            name = f"{curve}, skew {skew}: initial stiffness / that at skew 0"
            study.absolute(name, ratio, 1.0, TOLERANCE, "all tests: unaffected by skew")
        lines = {f"skew {s}": (p.closure_m / MM, p.force_n / 1.0e6) for s, p in pushes.items()}
        panels.append(Panel("closure (mm)", "force normal to the wall (MN)", lines, curve))
    study.figures["pushes"] = drawn(panels, columns=2, height_in=2.8)
