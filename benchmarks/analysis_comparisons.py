"""How much integrator, steps and rounding change the demands of a bridge with friction.

Prints tables as in docs/theory/analysis.md for one pair of records:
    python benchmarks/analysis_comparisons.py A.AT2 B.AT2 [--bridge osb1] [--skew-deg 30] \
        [--gap-mm 25] [--scale 1] [--window-s 9]
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What the comparisons are about: a variant with a positive skew, or none, and a motion."""

    motion: GroundMotion
    variant: Variant

    def run(
        self, settings: AnalysisSettings, *, mirror: bool = False
    ) -> tuple[AnalysisResult, float]:
        """Return the result and the processor time in s."""
        motion, variant = self.motion, self.variant
        if mirror:
            motion = motion.with_components(motion.accel_1_mps2, -motion.accel_2_mps2)
            variant = replace(variant, skew_deg=-variant.skew_deg)
        start = time.process_time()
        result = analyse(variant, Excitation(motion=motion), settings, ModelOptions())
        return result, time.process_time() - start


def changes(result: AnalysisResult, reference: AnalysisResult) -> str:
    """Return the changes of the peaks of the whole history in percent."""
    found, exact = result.whole_history, reference.whole_history
    return " | ".join(
        f"{100 * (found[name] / exact[name] - 1):+.2f}" if exact[name] else "-" for name in DEMANDS
    )


def steps(case: Case) -> Iterator[str]:
    """Yield the table of integrators and steps."""
    reference, cpu_s = case.run(REFERENCE)
    yield "integrator; steps in ms | " + " | ".join(DEMANDS) + " | iterations | failed | s"
    values = " | ".join(f"{reference.whole_history[name]:.4g}" for name in DEMANDS)
    cost = f"{reference.iterations} | {reference.failed_attempts} | {cpu_s:.1f}"
    yield f"reference | {values} | {cost}"
    for integrator, dt_s, contact_dt_s, event_dt_s in STEPS:
        settings = replace(
            DEFAULT,
            integrator=integrator,
            dt_s=dt_s,
            contact_dt_s=contact_dt_s,
            event_dt_s=event_dt_s,
        )
        result, cpu_s = case.run(settings)
        lengths = [f"{1e3 * step:g}" if step else "-" for step in (dt_s, contact_dt_s, event_dt_s)]
        name = f"{' '.join(map(str, integrator))}; {' / '.join(lengths)}"
        cost = f"{result.iterations} | {result.failed_attempts} | {cpu_s:.1f}"
        yield f"{name} | {changes(result, reference)} | {cost}"


def rounding(case: Case) -> Iterator[str]:
    """Yield how far the mirrored bridge is from the mirror image, by tolerance."""
    for tolerance_j in TOLERANCES_J:
        settings = replace(DEFAULT, tolerance_j=tolerance_j)
        image, straight = (case.run(settings, mirror=mirror)[0] for mirror in (True, False))
        found, exact = image.whole_history, straight.whole_history
        parts = [f"{abs(found[name] / exact[name] - 1):.1e}" for name in DEMANDS if exact[name]]
        yield f"{tolerance_j:g} J | {' | '.join(parts)}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs=2, type=Path)
    parser.add_argument("--bridge", default="osb1")
    parser.add_argument("--skew-deg", type=int, default=30)
    parser.add_argument("--gap-mm", type=int, default=25)
    parser.add_argument("--friction-pct", type=int, default=50)
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--window-s", type=float, default=9.0)
    given = parser.parse_args()
    motion = cut_to_strongest(read_motion(*given.files), given.window_s, 0.0).scaled(given.scale)
    variant = Variant(
        bridge=given.bridge,
        abutment="contact_friction",
        skew_deg=given.skew_deg,
        gap_mm=given.gap_mm,
        friction_pct=given.friction_pct,
    )
    case = Case(motion=motion, variant=variant)
    for table in (steps, rounding):
        sys.stdout.write(f"\n{motion.motion_id}, {variant.slug}: {table.__name__}\n")
        for row in table(case):
            sys.stdout.write(row + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
