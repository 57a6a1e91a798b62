"""The earthquake and site a synthetic motion is made for."""

import math
from dataclasses import dataclass
from typing import Final, Literal

from skewbridge.errors import InputError

type Mechanism = Literal["strike_slip", "reverse"]
type PulseOption = Literal["none", "all", "probability"]

# source: Dabaghi and Der Kiureghian (2018), range of the regression data; below M 6.5 the third
# predictor is not unambiguous in what could be read, so the model is not offered there.
MAGNITUDE_LIMITS: Final = (6.5, 7.9)
DISTANCE_LIMITS_KM: Final = (0.1, 31.0)
VS30_LIMITS_MPS: Final = (139.0, 2016.0)
ZTOR_LIMITS_KM: Final = (0.0, 20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Earthquake, path and site.

    Attributes:
        magnitude: Moment magnitude, 6.5 to 7.9.
        distance_km: Closest distance to the rupture, up to 31 km.
        vs30_mps: Average shear-wave velocity of the upper 30 m.
        mechanism: ``strike_slip`` or ``reverse`` (with oblique).
        ztor_km: Depth to the top of the rupture.
        rupture_to_site_km: Length of the rupture towards the site (strike-slip) or up-dip of the
            hypocentre (reverse); only matters for pulses.
        directivity_angle_deg: Angle between rupture direction and path to the site.
        pulse: Motions with a near-fault pulse: ``none``, ``all``, or by the model's
            ``probability`` of one.
    """

    magnitude: float
    distance_km: float
    vs30_mps: float
    mechanism: Mechanism = "strike_slip"
    ztor_km: float = 0.0
    rupture_to_site_km: float = 20.0
    directivity_angle_deg: float = 0.0
    pulse: PulseOption = "none"

    def __post_init__(self) -> None:
        for name, (low, high) in {
            "magnitude": MAGNITUDE_LIMITS,
            "distance_km": DISTANCE_LIMITS_KM,
            "vs30_mps": VS30_LIMITS_MPS,
            "ztor_km": ZTOR_LIMITS_KM,
            "rupture_to_site_km": (0.0, 500.0),
            "directivity_angle_deg": (0.0, 90.0),
        }.items():
            value = getattr(self, name)
            if not low <= value <= high:  # also refuses nan
                raise InputError(f"{name} must be within {low} to {high}, got {value}")
        if self.mechanism not in {"strike_slip", "reverse"}:
            raise InputError(f"mechanism must be strike_slip or reverse, got {self.mechanism!r}")
        if self.pulse not in {"none", "all", "probability"}:
            raise InputError(f"pulse must be none, all or probability, got {self.pulse!r}")

    @property
    def joyner_boore_km(self) -> float:
        """Distance to the surface projection of the rupture, of a vertical fault."""
        # ASSUME a vertical fault: rjb^2 = rrup^2 - ztor^2
        return math.sqrt(max(self.distance_km**2 - self.ztor_km**2, 0.0))

    @property
    def predictors(self) -> tuple[float, ...]:
        """The eight predictors of the regression of the model parameters."""
        log_r = 0.5 * math.log(self.distance_km**2 + 36.0)
        reverse = 1.0 if self.mechanism == "reverse" else 0.0
        return (
            1.0,
            self.magnitude,
            max(self.magnitude - 6.5, 0.0),
            log_r,
            self.magnitude * log_r,
            reverse * min(self.ztor_km, 1.0),
            math.log(min(self.vs30_mps, 1100.0)),
            self.rupture_to_site_km,
        )

    @property
    def pulse_probability(self) -> float:
        """Probability of a pulse in the direction it is largest.

        References:
            Shahi and Baker (2014) form as fitted in Dabaghi and Der Kiureghian (2018).
        """
        strike_slip = self.mechanism == "strike_slip"
        c = (0.457, 0.126, 0.244, 0.013) if strike_slip else (0.304, 0.072, 0.208, 0.021)
        exponent = c[0] + c[1] * self.distance_km - c[2] * math.sqrt(self.rupture_to_site_km)
        exponent += c[3] * self.directivity_angle_deg
        return 1.0 / (1.0 + math.exp(exponent))
