"""Residual / peak displacement of the bent of osb1, and of oscillators with other hysteresis.

Twelve motions of the suite `near`, scaled to a PGA of 0.9 g, act on osb1 without walls (roller)
and with contact and friction, gap 25 mm, skew 0. Each component also acts on oscillators with the
period and strength of the bent (0.75 s, 0.30 g, damping 5 %): bilinear with 1 % hardening, and
Takeda's rule with the unloading exponent 0.5. Prints the median and the largest ratio of each model
and the range of its displacement ductility; about a minute of processor time.
"""

import numpy as np
import openseespy.opensees as ops
from common import show

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.studies.paper_runs import paper_variant, strongest_motions

MOTIONS, PGA_G = 12, 0.9
PERIOD_S, STRENGTH_G, DAMPING, HARDENING = 0.75, 0.30, 0.05, 0.01
QUIET_S = 20.0  # free vibration of an oscillator


def bridge_peaks(abutment: str) -> list[tuple[float, float]]:
    """Return (residual / peak drift, displacement ductility) of osb1 under each motion."""
    case = paper_variant(abutment=abutment, gap_mm=25).normalised()
    capacity = bent_capacity(load_bridge("osb1"), 0)
    yields = capacity.yield_disp_m / capacity.clear_height_m
    found = []
    for motion in strongest_motions(MOTIONS, PGA_G):
        run = analyse(case, Excitation(motion=motion), AnalysisSettings(), ModelOptions())
        peak = run.whole_history["column_drift_ratio"]
        found.append((run.demands["column_residual_drift_ratio"] / peak, peak / yields))
    return found


def oscillator_peaks(rule: str) -> list[tuple[float, float]]:
    """Return (residual / peak, ductility) of an oscillator under each component."""
    parts = [
        (part, motion.dt_s)
        for motion in strongest_motions(MOTIONS, PGA_G)
        for part in motion.along_axes(0.0)
    ]
    return [oscillator(np.asarray(part), dt_s, rule) for part, dt_s in parts]


def oscillator(accel_mps2: np.ndarray, dt_s: float, rule: str) -> tuple[float, float]:
    """Return the residual / peak displacement and the ductility of one oscillator."""
    omega = 2.0 * np.pi / PERIOD_S
    strength, yields = STRENGTH_G * G_MPS2, STRENGTH_G * G_MPS2 / omega**2
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, 2):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    if rule == "bilinear":
        ops.uniaxialMaterial("Steel01", 1, strength, omega**2, HARDENING)
    else:
        points = [
            value
            for ductility in (1.0, 20.0, 40.0)
            for value in (strength * (1.0 + HARDENING * (ductility - 1.0)), ductility * yields)
        ]
        both = (*points, *(-value for value in points))
        ops.uniaxialMaterial("Hysteretic", 1, *both, 1.0, 1.0, 0.0, 0.0, 0.5)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1, "-doRayleigh", 1)
    ops.rayleigh(0.0, 0.0, 0.0, 2.0 * DAMPING / omega)
    values = np.concatenate([accel_mps2, np.zeros(round(QUIET_S / dt_s))])
    ops.timeSeries("Path", 1, "-dt", dt_s, "-values", *values.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", 1.0e-9, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient", "-noWarnings")
    moved = []
    for _ in values:
        if ops.analyze(1, dt_s) != 0:
            raise RuntimeError("the oscillator has no equilibrium")
        moved.append(abs(ops.nodeDisp(2, 1)))
    return moved[-1] / max(moved), max(moved) / yields


if __name__ == "__main__":
    peaks = {name: bridge_peaks(name) for name in ("roller", "contact_friction")}
    peaks |= {name: oscillator_peaks(name) for name in ("bilinear", "takeda")}
    for name, found in peaks.items():
        ratios, ductilities = np.array(found).T
        show(
            {
                "model": name,
                "median": round(float(np.median(ratios)), 3),
                "largest": round(float(ratios.max()), 3),
                "ductility": [round(float(x), 1) for x in np.quantile(ductilities, [0, 0.5, 1])],
            }
        )
