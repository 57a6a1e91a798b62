"""How much integrator, steps and rounding change the demands of a bridge with friction.

Prints tables as in docs/theory/analysis.md for one pair of records:
    python benchmarks/analysis_comparisons.py --files A.AT2 B.AT2 [--bridge osb1] [--skew-deg 30] \
        [--gap-mm 25] [--scale 1] [--window-s 9]
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from common import FRICTION_PCT, Case, cpu_s, options, osb1

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.read import read_motion
from skewbridge.variant.options import ModelOptions

DEMANDS = (
    "column_shear_kn",
    "column_drift_ratio",
    "deck_disp_x_m",
    "deck_rotation_rad",
    "unseating_m",
    "abutment_passive_m",
    "slip_work_kj",
)
DEFAULT = AnalysisSettings(energy=False)
REFERENCE = replace(DEFAULT, dt_s=0.0005, contact_dt_s=None, event_dt_s=None, tolerance_j=1.0e-8)
# Integrator; regular step, largest step in contact, largest step at events.
NEWMARK = ("Newmark", 0.5, 0.25, "-form", "V")
STEPS = (
    (("Houbolt",), 0.0005, None, None),
    (("HHT", 0.7), 0.0005, None, None),
    (("Houbolt",), 0.005, None, None),
    (("HHT", 0.9), 0.0025, 0.00125, 0.001),
    (NEWMARK, 0.010, 0.010, 0.0003125),
    (NEWMARK, 0.010, 0.005, 0.0003125),
    (NEWMARK, 0.005, 0.005, 0.0003125),
    (NEWMARK, 0.0025, 0.0025, 0.0003125),
)
TOLERANCES_J = (1.0e-2, 1.0e-4, 1.0e-8)


def run(
    case: Case, settings: AnalysisSettings, *, mirror: bool = False
) -> tuple[AnalysisResult, float]:
    """Return the result and the processor time in s, of the mirror image if asked."""
    motion, variant = case.motion, case.variant
    if mirror:
        motion = motion.with_components(motion.accel_1_mps2, -motion.accel_2_mps2)
        variant = replace(variant, skew_deg=-variant.skew_deg)
    return cpu_s(lambda: analyse(variant, Excitation(motion=motion), settings, ModelOptions()))


def changes(result: AnalysisResult, reference: AnalysisResult) -> str:
    """Return the changes of the peaks of the whole history in percent."""
    found, exact = result.whole_history, reference.whole_history
    return " | ".join(
        f"{100 * (found[name] / exact[name] - 1):+.2f}" if exact[name] else "-" for name in DEMANDS
    )


def steps(case: Case) -> Iterator[str]:
    """Yield the table of integrators and steps."""
    reference, seconds = run(case, REFERENCE)
    yield "integrator; steps in ms | " + " | ".join(DEMANDS) + " | iterations | failed | s"
    values = " | ".join(f"{reference.whole_history[name]:.4g}" for name in DEMANDS)
    cost = f"{reference.iterations} | {reference.failed_attempts} | {seconds:.1f}"
    yield f"reference | {values} | {cost}"
    for integrator, dt_s, contact_dt_s, event_dt_s in STEPS:
        settings = replace(
            DEFAULT,
            integrator=integrator,
            dt_s=dt_s,
            contact_dt_s=contact_dt_s,
            event_dt_s=event_dt_s,
        )
        result, seconds = run(case, settings)
        lengths = [f"{1e3 * step:g}" if step else "-" for step in (dt_s, contact_dt_s, event_dt_s)]
        name = f"{' '.join(map(str, integrator))}; {' / '.join(lengths)}"
        cost = f"{result.iterations} | {result.failed_attempts} | {seconds:.1f}"
        yield f"{name} | {changes(result, reference)} | {cost}"


def rounding(case: Case) -> Iterator[str]:
    """Yield how far the mirrored bridge is from the mirror image, by tolerance."""
    for tolerance_j in TOLERANCES_J:
        settings = replace(DEFAULT, tolerance_j=tolerance_j)
        image, straight = (run(case, settings, mirror=mirror)[0] for mirror in (True, False))
        found, exact = image.whole_history, straight.whole_history
        parts = [f"{abs(found[name] / exact[name] - 1):.1e}" for name in DEMANDS if exact[name]]
        yield f"{tolerance_j:g} J | {' | '.join(parts)}"


def main() -> None:
    """Print the tables."""
    given = options(
        __doc__,
        files=("A.AT2", "B.AT2"),
        bridge="osb1",
        skew_deg=30,
        gap_mm=25,
        friction_pct=FRICTION_PCT,
        scale=1.0,
        window_s=9.0,
    )
    motion = read_motion(*map(Path, given.files))
    motion = cut_to_strongest(motion, given.window_s, 0.0).scaled(given.scale)
    variant = osb1(given.skew_deg, given.gap_mm, given.friction_pct)
    case = Case(variant=replace(variant, bridge=given.bridge), motion=motion)
    for table in (steps, rounding):
        sys.stdout.write(f"\n{case.name}: {table.__name__}\n")
        for row in table(case):
            sys.stdout.write(row + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
