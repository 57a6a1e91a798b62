"""How much integrator, step, penalties and modelling choices change the demands of OSB1.

Prints the tables of docs/theory/analysis.md for one motion and skew:
    python benchmarks/analysis_comparisons.py A.AT2 B.AT2 --skew-deg 30 [--window-s 8]
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

DEMANDS = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
FORCES = ("backwall_force_kn", "shear_key_force_kn", "friction_force_kn")
REFERENCE = AnalysisSettings(dt_s=0.0005, integrator=("Newmark", 0.5, 0.25), energy=False)
INTEGRATORS = (
    ("Houbolt",),
    ("HHT", 0.8),
    ("Newmark", 0.6, 0.3025),
    ("Newmark", 0.5, 0.25),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What one comparison is about."""

    motion: GroundMotion
    skew_deg: int
    friction_pct: int = 50

    def run(
        self, settings: AnalysisSettings, options: ModelOptions, *, mirror: bool = False
    ) -> tuple[AnalysisResult, float]:
        """Return the result and the processor time in s."""
        motion = self.motion
        if mirror:
            motion = motion.with_components(motion.accel_1_mps2, -motion.accel_2_mps2)
        variant = Variant(
            bridge="osb1",
            abutment="contact_friction",
            skew_deg=-self.skew_deg if mirror else self.skew_deg,
            gap_mm=51,
            friction_pct=self.friction_pct,
        )
        start = time.process_time()
        result = analyse(variant, Excitation(motion=motion), settings, options, histories=mirror)
        return result, time.process_time() - start


def window(motion: GroundMotion, window_s: float) -> GroundMotion:
    """Return the motion from half a second before 0.1 % of its Arias intensity on."""
    build_up = np.cumsum(motion.accel_1_mps2**2 + motion.accel_2_mps2**2)
    first = int(np.searchsorted(build_up / build_up[-1], 0.001) - 0.5 / motion.dt_s)
    part = slice(max(first, 0), max(first, 0) + round(window_s / motion.dt_s))
    return motion.with_components(motion.accel_1_mps2[part], motion.accel_2_mps2[part])


def percent(result: AnalysisResult, reference: AnalysisResult) -> str:
    """Return the changes of the demands, then of the forces, in percent."""
    return " | ".join(
        " ".join(f"{100 * (result.demands[d] / reference.demands[d] - 1):+.1f}" for d in group)
        if all(reference.demands[d] for d in group)
        else "-"
        for group in (DEMANDS, FORCES)
    )


def integrators(case: Case) -> Iterator[str]:
    """Yield the rows of the table of integrators and steps."""
    reference, _ = case.run(REFERENCE, ModelOptions())
    yield "reference " + " ".join(f"{reference.demands[d]:.4g}" for d in (*DEMANDS, *FORCES))
    for integrator in INTEGRATORS:
        for dt_s in (0.001, 0.0025, 0.005, 0.0075) if integrator == ("Houbolt",) else (0.005,):
            settings = AnalysisSettings(dt_s=dt_s, integrator=integrator, energy=False)
            result, cpu_s = case.run(settings, ModelOptions())
            name = " ".join(map(str, integrator))
            yield (
                f"{name} {dt_s:g} | {percent(result, reference)} | {result.iterations} | "
                f"{result.failed_attempts} | {cpu_s:.2f}"
            )


def rounding(case: Case) -> Iterator[str]:
    """Yield how far the mirrored bridge is from the mirror image, by integrator and tolerance."""
    for integrator in INTEGRATORS[:3]:
        for tolerance_j in (1e-2, 1e-5, 1e-8):
            settings = AnalysisSettings(
                integrator=integrator, tolerance_j=tolerance_j, energy=False
            )
            image, cpu_s = case.run(settings, ModelOptions(), mirror=True)
            straight, _ = case.run(settings, ModelOptions())
            change = max(abs(image.demands[d] / straight.demands[d] - 1) for d in DEMANDS[1:])
            name = " ".join(map(str, integrator))
            yield f"{name} {tolerance_j:g} J | {change:.1e} | {image.iterations} | {cpu_s:.2f}"


def choices(case: Case) -> Iterator[str]:
    """Yield the effect of modelling choices and penalties at the default step."""
    settings = AnalysisSettings(energy=False)
    base, cpu_s = case.run(settings, ModelOptions())
    yield f"default | {' '.join(f'{base.demands[d]:.4g}' for d in DEMANDS)} | | {cpu_s:.2f}"
    changes: dict[str, ModelOptions] = {
        "extrapolated coupling": ModelOptions(coupling="extrapolated"),
        "corotational arrays": ModelOptions(arrays="corotational"),
        "lobatto5 columns": ModelOptions(column_integration="lobatto5"),
        "normal penalty x 1/2": ModelOptions(normal_stiffness_factor=0.5),
        "normal penalty x 2": ModelOptions(normal_stiffness_factor=2.0),
        "tangential penalty x 1/4": ModelOptions(tangent_stiffness_factor=0.25),
        "tangential penalty x 1/2": ModelOptions(tangent_stiffness_factor=0.5),
        "tangential penalty x 2": ModelOptions(tangent_stiffness_factor=2.0),
        "wall dashpots 5 %": ModelOptions(wall_dashpot_ratio=0.05),
        "wall dashpots 20 %": ModelOptions(wall_dashpot_ratio=0.20),
        "9 points per backwall": ModelOptions(backwall_points=9),
    }
    for name, options in changes.items():
        result, cpu_s = case.run(settings, options)
        yield (f"{name} | {percent(result, base)} | {result.failed_attempts} | {cpu_s:.2f}")
    result, cpu_s = case.run(AnalysisSettings(scheme="paper", energy=False), ModelOptions())
    yield f"scheme paper | {percent(result, base)} | {result.failed_attempts} | {cpu_s:.2f}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs=2, type=Path)
    parser.add_argument("--skew-deg", type=int, default=30)
    parser.add_argument("--friction-pct", type=int, default=50)
    parser.add_argument("--window-s", type=float, default=8.0)
    parser.add_argument("--tables", nargs="+", default=["integrators", "rounding", "choices"])
    given = parser.parse_args()
    motion = window(read_motion(*given.files), given.window_s)
    case = Case(motion=motion, skew_deg=given.skew_deg, friction_pct=given.friction_pct)
    tables = {"integrators": integrators, "rounding": rounding, "choices": choices}
    for name in given.tables:
        sys.stdout.write(
            f"\n{motion.motion_id}, skew {given.skew_deg}, "
            f"friction {given.friction_pct} %: {name}\n"
        )
        for row in tables[name](case):
            sys.stdout.write(row + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
