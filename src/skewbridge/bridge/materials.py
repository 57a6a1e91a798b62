"""Stress-strain data of column concrete and reinforcement."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.bridge.catalogue.data import ColumnData
from skewbridge.units import GPA, MPA

type FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Reinforcing steel at its expected strength, bilinear in the model.

    The rupture strain is the reduced ultimate one, the hardening ratio post-yield over elastic
    stiffness.
    """

    yield_pa: float
    modulus_pa: float = 200e9
    hardening_ratio: float = 0.01  # source: 1 % is usual
    rupture_strain: float = 0.06  # source: Caltrans SDC 1.7 section 3.2.3


STEELS: Final = {
    # source: Caltrans SDC 1.7 section 3.2.3, expected A706 values
    "a706": Steel(yield_pa=469e6),
    # source: Caltrans SDC 1.7 table 3.2.1 older bars: expected 1.2 times the nominal 276 MPa
    "grade40": Steel(yield_pa=331e6),
    # source: PyPBEE examples, bridges A-C: A706 with mean properties
    "kaviani": Steel(yield_pa=476.7e6, modulus_pa=201.3e9),
}


def steel_of(column: ColumnData) -> Steel:
    """Return the reinforcing steel of a column."""
    steel = STEELS[column.steel]
    return replace(steel, yield_pa=column.steel_strength_factor * steel.yield_pa)


@dataclass(frozen=True, slots=True, kw_only=True)
class Concrete:
    """Popovics curve of Mander's model, positive in compression, with the initial tangent.

    The curve ends at the ultimate strain (spalling or first hoop rupture).
    """

    peak_pa: float
    peak_strain: float
    modulus_pa: float
    ultimate_strain: float

    def stress_pa(self, strain: ArrayLike) -> FloatArray:
        """Return the stress at compressive strains; zero in tension and past the ultimate strain.

        References:
            Mander, Priestley and Park (1988), J. Struct. Eng. 114(8), 1804-1826, eq. 3-6.
        """
        ratio = np.maximum(np.asarray(strain, dtype=np.float64), 0.0) / self.peak_strain
        secant = self.peak_pa / self.peak_strain
        power = self.modulus_pa / (self.modulus_pa - secant)
        curve = self.peak_pa * ratio * power / (power - 1.0 + ratio**power)
        return np.where(ratio * self.peak_strain > self.ultimate_strain, 0.0, curve)


def cover_concrete(column: ColumnData) -> Concrete:
    """Return the unconfined concrete at its expected strength."""
    return Concrete(
        peak_pa=column.expected_concrete_strength_mpa * MPA,
        peak_strain=0.002,  # source: SDC 1.7 section 3.2.6
        modulus_pa=column.elastic_modulus_gpa * GPA,
        ultimate_strain=0.005,  # source: SDC 1.7 section 3.2.6
    )


def confinement_pressure_pa(column: ColumnData) -> float:
    """Return the effective lateral pressure of circular hoops at their expected yield.

    References:
        Mander, Priestley and Park (1988), eq. 12-19, circular hoops.
    """
    circle_m = column.hoop_circle_m
    clear_m = 1e-3 * (column.hoop_spacing_mm - column.hoop_diameter_mm)
    bars_m2 = column.bar_count * column.bar_area_mm2 * 1e-6
    core_ratio = bars_m2 / (np.pi * circle_m**2 / 4)
    arching = max(1.0 - clear_m / (2 * circle_m), 0.0) ** 2 / (1.0 - core_ratio)
    return 0.5 * arching * hoop_volume_ratio(column) * steel_of(column).yield_pa


def hoop_volume_ratio(column: ColumnData) -> float:
    """Return the volume of hoops over the volume of the core."""
    return 4 * column.hoop_area_mm2 * 1e-6 / (column.hoop_circle_m * 1e-3 * column.hoop_spacing_mm)


def core_concrete(column: ColumnData) -> Concrete:
    """Return the confined concrete after Mander.

    The ultimate strain is the energy-balance shortcut 0.004 + 1.4 rho_s f_yh eps_su / f_cc.

    References:
        Mander, Priestley and Park (1988), eq. 29 and 5; Priestley, Seible and Calvi (1996),
        Seismic Design and Retrofit of Bridges, eq. 5.14.
    """
    plain = cover_concrete(column)
    pressure = confinement_pressure_pa(column) / plain.peak_pa
    gain = -1.254 + 2.254 * np.sqrt(1.0 + 7.94 * pressure) - 2.0 * pressure
    peak_pa = plain.peak_pa * float(gain)
    peak_strain = plain.peak_strain * (1.0 + 5.0 * (peak_pa / plain.peak_pa - 1.0))
    hoop_energy = hoop_volume_ratio(column) * steel_of(column).yield_pa
    hoop_strain = 0.09  # source: SDC 1.7 section 3.2.3, reduced ultimate strain of #8 bars
    return Concrete(
        peak_pa=peak_pa,
        peak_strain=peak_strain,
        modulus_pa=plain.modulus_pa,
        ultimate_strain=max(0.004 + 1.4 * hoop_energy * hoop_strain / peak_pa, peak_strain),
    )
