"""Measures and spectra of motion files, under the names that the command line prints."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from skewbridge.motions.folder import list_motions
from skewbridge.motions.formats import Given
from skewbridge.motions.intensity import (
    component_measures,
    conditioned_levels,
    conditioned_periods,
    housner_intensity,
    motion_measures,
    peak_g,
)
from skewbridge.motions.read import read_motion, read_trace
from skewbridge.motions.record import Vector
from skewbridge.motions.spectrum import component_psa, pair_psa
from skewbridge.motions.suite import read_entry
from skewbridge.motions.synthesis.bssa14 import bssa14
from skewbridge.motions.synthesis.ddk18 import Scenario
from skewbridge.units import G_MPS2

SPECTRUM_PERIODS_S: Final = (
    0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0,
    4.0, 5.0, 7.5, 10.0,
)  # fmt: skip


def pair_summary(
    first: Path,
    second: Path,
    given: Given,
    t1_s: float | None,
    periods_s: Sequence[float] | None = None,
) -> dict[str, Any]:
    """Return the measures and spectra of a pair of files, and the messages of the reader."""
    motion = read_motion(first, second, given)
    pair, dt_s = motion.components, motion.dt_s
    periods = periods_s or SPECTRUM_PERIODS_S
    spectra = pair_psa(*pair, dt_s, periods)
    psa_mps2 = {
        "rotd50": spectra.rotd50_mps2,
        "rotd100": spectra.rotd100_mps2,
        "h1": spectra.psa_1_mps2,
        "h2": spectra.psa_2_mps2,
    }
    return {
        **motion_measures(motion, t1_s),
        **{f"pga_h{n}_g": peak_g(accel) for n, accel in enumerate(pair, start=1)},
        **{f"housner_h{n}_m": housner_intensity(a, dt_s) for n, a in enumerate(pair, start=1)},
        "dt_s": dt_s,
        "npts": motion.npts,
        "periods_s": list(periods),
        **{f"psa_{name}_g": (values / G_MPS2).tolist() for name, values in psa_mps2.items()},
        "messages": list(motion.messages),
    }


def component_summary(
    path: Path, given: Given, t1_s: float | None = None, periods_s: Sequence[float] | None = None
) -> dict[str, Any]:
    """Return the measures and the spectrum of one file, and the messages of the reader."""
    trace = read_trace(path, given)
    periods = periods_s or SPECTRUM_PERIODS_S
    measures = component_measures(trace.accel_mps2, trace.dt_s)
    if t1_s is not None:
        psa_g = component_psa(trace.accel_mps2, trace.dt_s, conditioned_periods(t1_s)) / G_MPS2
        measures["sa_t1_g"], measures["saavg_g"] = conditioned_levels(psa_g)
    return {
        # The unit stays last: pga_h1_g for pga_g
        **{"_h1_".join(name.rsplit("_", 1)): value for name, value in measures.items()},
        "dt_s": trace.dt_s,
        "npts": int(trace.accel_mps2.size),
        "periods_s": list(periods),
        "psa_h1_g": (component_psa(trace.accel_mps2, trace.dt_s, periods) / G_MPS2).tolist(),
        "messages": list(trace.messages),
    }


def read_components(files: list[Path], given: Given) -> tuple[str, float, dict[str, Vector]]:
    """Return name, time step and components (m/s2, by file name) of one or two files."""
    if len(files) == 1:
        trace = read_trace(files[0], given)
        return files[0].stem, trace.dt_s, {files[0].name: trace.accel_mps2}
    motion = read_motion(files[0], files[1], given)
    labels = [path.name for path in files]
    return motion.motion_id, motion.dt_s, dict(zip(labels, motion.components, strict=True))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SuiteTable:
    """RotD50 spectra of a folder of motions in g, shape (motions, periods).

    The model has name, median in g and dispersion of BSSA14 at the same periods, where all motions
    belong to one synthetic scenario; else it is None.
    """

    periods_s: Vector
    rotd50_g: Vector
    model: tuple[str, Vector, Vector] | None


def suite_table(folder: Path) -> SuiteTable:
    """Return the spectra of the motions of a folder."""
    motions = [read_entry(entry) for entry in list_motions(folder)]
    periods_s = np.array([period for period in SPECTRUM_PERIODS_S if 0.03 <= period <= 7.5])
    rotd50_g = [
        pair_psa(*motion.components, motion.dt_s, periods_s).rotd50_mps2 / G_MPS2
        for motion in motions
    ]
    model = None
    scenarios = {(m.event, m.magnitude, m.distance_km, m.vs30_mps) for m in motions}
    if len(scenarios) == 1 and motions[0].event.startswith("DDK18"):
        event, magnitude, distance_km, vs30_mps = scenarios.pop()
        scenario = Scenario(
            magnitude=magnitude,
            distance_km=distance_km,
            vs30_mps=vs30_mps,
            mechanism="reverse" if "reverse" in event else "strike_slip",
        )
        model = ("BSSA14", *bssa14(scenario, periods_s))
    return SuiteTable(periods_s=periods_s, rotd50_g=np.array(rotd50_g), model=model)
