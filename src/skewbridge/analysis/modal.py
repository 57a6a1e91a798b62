"""Modes of a model with open gaps, the conditioning period T1, and Rayleigh damping."""

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Final

import openseespy.opensees as ops

from skewbridge.bridge.assembly import GravityError, Mode, modes_of, period_s, solver_log
from skewbridge.bridge.frame import BridgeModel, Damping
from skewbridge.bridge.handles import ColumnHandle
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, column_axial_forces_n, domain, support_reactions_n
from skewbridge.errors import SolutionError
from skewbridge.units import KN, TONNE
from skewbridge.variant.axes import USUAL
from skewbridge.variant.options import ModelOptions, RayleighKind
from skewbridge.variant.variant import Variant

logger = logging.getLogger(__name__)

#: Largest relative difference between the periods of the file and of the model.
#: ASSUME 5 %: record-to-record dispersion of Sa between periods this close is below 0.1.
TOLERANCE: Final = 0.05
#: Modal mass of the second mode / first mode above which the two share the motion.
#: ASSUME two thirds.
SHARED_MASS_RATIO: Final = 2.0 / 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalResult:
    """Dead-load state and modes of a variant."""

    weight_kn: float
    mass_t: float  # horizontal mass of deck, caps and columns
    column_axial_kn: tuple[float, ...]
    abutment_reaction_kn: tuple[float, float]
    modes: tuple[Mode, ...]

    def period_s(self, direction: str) -> float:
        """Return the period along ``x, y, z`` or about z (``rz``)."""
        return period_s(self.modes, direction)


def modal_properties(variant: Variant, options: ModelOptions | None = None) -> ModalResult:
    """Build a variant, apply gravity and return its modes."""
    with domain():
        model = build(variant, options or ModelOptions())
        left, right = support_reactions_n(model)
        return ModalResult(
            weight_kn=model.weight_n / KN,
            mass_t=sum(model.frame.loads.masses_kg.values()) / TONNE,
            column_axial_kn=tuple(force / KN for force in column_axial_forces_n(model)),
            abutment_reaction_kn=(left / KN, right / KN),
            modes=modes_of(model),
        )


def standing_bridge(bridge: str) -> ModalResult:
    """Return dead-load state and modes of a bridge with pads and open gaps, at zero skew."""
    try:
        with solver_log(None):
            return modal_properties(Variant.at(bridge, "contact_friction", USUAL))
    except GravityError as error:
        raise SolutionError(f"{load_structure(bridge).name}: {error}") from error


def conditioning_period_s(modes: ModalResult) -> float:
    """Return T1 in s, the geometric mean of the longitudinal and the transverse period.

    It is the same for all variants; otherwise runs could not be paired.
    """
    return sqrt(modes.period_s("x") * modes.period_s("y"))


def warn_of_periods(bridges: Iterable[str]) -> None:
    """Log a warning for each finding of `periods_of_file` about these bridges."""
    for name in dict.fromkeys(bridges):
        for finding in periods_of_file(name, standing_bridge(name)):
            logger.warning("%s", finding)


def periods_of_file(bridge: str, modes: ModalResult) -> list[str]:
    """Return findings about T1 in a bridge file; ``modes`` comes from `standing_bridge`."""
    structure, model_s = load_structure(bridge), conditioning_period_s(modes)
    findings: list[str] = []
    change = structure.t1_s / model_s - 1.0
    if abs(change) > TOLERANCE:
        findings.append(
            f"{structure.name}: t1_s = {structure.t1_s:.4g} s differs by {change:+.1%} from T1 of "
            f"its model, {model_s:.4g} s; Sa(T1) and Sa_avg of every motion use t1_s: correct it "
            "in the file of the bridge"
        )
    for direction, adjective in (("x", "longitudinal"), ("y", "transverse")):
        shares = ((getattr(mode, f"mass_{direction}"), mode.period_s) for mode in modes.modes)
        first, second, *_ = sorted(shares, reverse=True)
        (first_share, first_period_s), (second_share, second_period_s) = first, second
        if second_share > SHARED_MASS_RATIO * first_share:
            findings.append(
                f"{structure.name}: the {adjective} motion is shared by modes of "
                f"{first_period_s:.3g} s ({first_share:.0%} of the mass) and "
                f"{second_period_s:.3g} s ({second_share:.0%}): "
                "small changes of the bridge can switch T1 between them; use Sa(1 s), Sa_avg or PGV"
            )
    return findings


def rayleigh_factors(
    damping: Damping, ratio: float, kind: RayleighKind = "mass_and_stiffness"
) -> tuple[float, float]:
    """Return a0 (1/s) and a1 (s) that give a damping ratio at its two periods.

    Damping that is proportional to stiffness only has the ratio at the long period.
    """
    if kind == "stiffness":
        return 0.0, ratio * damping.long_period_s / pi
    omega_1, omega_2 = 2 * pi / damping.long_period_s, 2 * pi / damping.short_period_s
    return 2 * ratio * omega_1 * omega_2 / (omega_1 + omega_2), 2 * ratio / (omega_1 + omega_2)


def apply_rayleigh(model: BridgeModel, kind: RayleighKind | None = None) -> tuple[float, float]:
    """Apply Rayleigh damping a0 M + a1 K to deck and columns only; return a0 (1/s) and a1 (s).

    K is the stiffness of the last committed step (see `damp_columns`). ``kind`` overrides the
    option ``rayleigh`` of the model.
    """
    damping, options, region = model.frame.damping, model.options, model.tags.region
    ratio = damping.ratio * options.damping_factor
    a0, a1 = rayleigh_factors(damping, ratio, kind or options.rayleigh)
    damped = dict.fromkeys(
        int(node) for element in damping.elements for node in ops.eleNodes(element)
    )
    ops.region(region(), "-nodeOnly", *damped, "-rayleigh", a0, 0.0, 0.0, 0.0)
    ops.region(region(), "-eleOnly", *damping.elements, "-rayleigh", 0.0, 0.0, 0.0, a1)
    return a0, a1


def damp_columns(columns: Sequence[ColumnHandle], a1_s: float, *, by_tangent: bool) -> None:
    """Make the damping of columns proportional to their current tangent or committed stiffness.

    The stiffness of the last committed step causes an error of first order in the time step; the
    tangent makes Newton's method cycle when contacts and yielding columns change together.
    """
    factors = (a1_s, 0.0, 0.0) if by_tangent else (0.0, 0.0, a1_s)
    for column in columns:
        ops.setElementRayleighDampingFactors(column.element, 0.0, *factors)
