"""The deck cases C1 to C5 of docs/theory/verification.md and their tabulated peaks."""

from dataclasses import dataclass
from math import cos, pi, radians, sqrt
from typing import Any, Final

from skewbridge.units import G_MPS2
from skewbridge.verification.references.case_files import DeckCase, PulseCase

# source: half of g = 9.81 m/s2 and the 0.5 s pulse of the paper's Fig 4; the values with which the
# references were computed.
PULSE_MPS2: Final = 4.905
PULSE_PERIOD_S: Final = 0.5
LENGTH_M: Final = 30.0
# Displacements are reported over this length: pulse amplitude over its frequency squared.
SCALE_M: Final = PULSE_MPS2 / (2.0 * pi / PULSE_PERIOD_S) ** 2
# ASSUME the dimensionless gap 0.1 of the paper is measured along the deck.
GAP_ALONG_M: Final = 0.1 * SCALE_M


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedCase:
    """Geometry and friction of a tabulated case."""

    name: str
    width_m: float
    skew_deg: float
    friction: float


C1: Final = NamedCase(name="C1", width_m=15.0, skew_deg=30.0, friction=0.0)
C2: Final = NamedCase(name="C2", width_m=15.0, skew_deg=30.0, friction=0.2)
C3: Final = NamedCase(name="C3", width_m=10.0, skew_deg=30.0, friction=0.0)
C4: Final = NamedCase(name="C4", width_m=10.0, skew_deg=30.0, friction=0.2)
C5: Final = NamedCase(name="C5", width_m=10.0, skew_deg=45.0, friction=0.2)
NAMED_CASES: Final = (C1, C2, C3, C4, C5)


def bearing_fields(
    length_m: float, width_m: float, skew_deg: float, period_s: float
) -> dict[str, float]:
    """Return plan and periods of a deck on bearings spread along its skewed ends.

    The period is that along both axes; that of rotation follows from where the bearings are.
    """
    skew = radians(skew_deg)
    radius2 = (length_m**2 + (width_m / cos(skew)) ** 2) / 12.0
    spread2 = length_m**2 / 4.0 + (width_m / cos(skew)) ** 2 / 12.0
    return {
        "length_m": length_m,
        "width_m": width_m,
        "skew_deg": skew_deg,
        "period_x_s": period_s,
        "period_y_s": period_s,
        "period_theta_s": period_s * sqrt(radius2 / spread2),
    }


def deck_case(named: NamedCase, **changes: Any) -> DeckCase:
    """Return a tabulated case: 1000 kg, Kn = 1e7 N/m, bearings of 0.5 s, 5 % damping.

    The changes are fields of `DeckCase`.
    """
    # ASSUME mass, periods and damping: the paper does not give them.
    fields: dict[str, Any] = {
        "mass_kg": 1000.0,
        "damping_ratio": 0.05,
        "gap_normal_m": GAP_ALONG_M * cos(radians(named.skew_deg)),
        "friction": named.friction,
        "normal_stiffness_n_per_m": 1.0e7,
        "dt_s": 1.0e-4,
        "duration_s": 2.0,
        "pulse": PulseCase(kind="cosine", amplitude_g=PULSE_MPS2 / G_MPS2, period_s=PULSE_PERIOD_S),
    }
    plan = bearing_fields(LENGTH_M, named.width_m, named.skew_deg, period_s=0.5)
    return DeckCase.model_validate(plan | fields | changes)
