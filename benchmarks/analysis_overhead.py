"""What reading, contact updates and the energy balance cost beside the solver.

The model is OSB1 with `contact` abutments (no friction: the same iterations in every row). Prints
processor time of each loop over that of the bare one, best of some interleaved repeats:
    python benchmarks/analysis_overhead.py A.AT2 B.AT2 [--skew-deg 30] [--duration-s 8]
"""

import argparse
import sys
import time
from pathlib import Path

import openseespy.opensees as ops

from skewbridge.analysis.damping import apply_rayleigh
from skewbridge.analysis.energy import EnergyBalance
from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.monitor import Monitor
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.status import Watch
from skewbridge.analysis.step_loop import configure_solver, solver_log
from skewbridge.bridge.model import build, domain
from skewbridge.motions.read import read_motion
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

LOOPS = ("bare", "contacts", "contacts, demands", "contacts, demands, energy")


def loop_s(loop: str, ground: GroundInput, settings: AnalysisSettings, skew_deg: int) -> float:
    """Return the processor time of all steps."""
    variant = Variant(
        bridge="osb1", abutment="contact", skew_deg=skew_deg, gap_mm=51, friction_pct=0
    )
    with solver_log(None), domain():
        model = build(variant, ModelOptions())
        rayleigh = apply_rayleigh(model)
        ground.apply(model.tags)
        monitor = Monitor(model)
        watch = Watch(model, monitor.layout, monitor.read(0.0), settings)
        energy = EnergyBalance(model, monitor, ground.at, rayleigh)
        configure_solver(settings)
        ops.algorithm("KrylovNewton")
        ops.integrator(*settings.integrator_command)
        ops.analysis("Transient", "-noWarnings")
        contacts = model.contacts if "contacts" in loop else None
        reads, adds = "demands" in loop, "energy" in loop
        start = time.process_time()
        for _ in range(ground.steps):
            if ops.analyze(1, settings.dt_s) != 0:
                message = "a step failed: choose a weaker motion"
                raise SystemExit(message)
            if contacts is not None:
                contacts.after_step(settings.dt_s)
            if reads:
                row = monitor.read(ops.getTime())
                watch.diverged(row)
                watch.collapsed(row)
            if adds:
                energy.collect()
        return time.process_time() - start


def main() -> None:
    """Print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs=2, type=Path)
    parser.add_argument("--skew-deg", type=int, default=30)
    parser.add_argument("--duration-s", type=float, default=8.0)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    settings = AnalysisSettings(duration_s=given.duration_s)
    ground = GroundInput(Excitation(motion=read_motion(*given.files)), settings)
    best = dict.fromkeys(LOOPS, float("inf"))
    for _ in range(given.repeats):
        for loop in LOOPS:
            best[loop] = min(best[loop], loop_s(loop, ground, settings, given.skew_deg))
    for loop, seconds in best.items():
        per_step_ms = 1e3 * seconds / ground.steps
        sys.stdout.write(f"{loop:28s} {per_step_ms:.3f} ms/step  {seconds / best['bare']:.3f}\n")


if __name__ == "__main__":
    main()
