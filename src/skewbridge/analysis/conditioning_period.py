"""The conditioning period T1 of a bridge by its own model, beside the one in its file."""

import logging
from collections.abc import Iterable
from math import sqrt
from typing import Final

from skewbridge.analysis.modal import ModalResult, modal_properties
from skewbridge.analysis.step_loop import solver_log
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.gravity import GravityError
from skewbridge.errors import SolutionError
from skewbridge.variant.axes import AXES
from skewbridge.variant.variant import Variant

logger = logging.getLogger(__name__)

#: Between the period of the file and that of the model; beyond it intensities belong to another
#: bridge. ASSUME 5 %: record-to-record dispersion of Sa between such near periods is below 0.1.
TOLERANCE: Final = 0.05
#: Of the largest modal mass, from which the mode after it counts. ASSUME two thirds.
SHARED: Final = 2.0 / 3.0


def standing_bridge(bridge: str) -> ModalResult:
    """Return the dead-load state and the modes of a bridge with pads and open gaps, at zero skew.

    Raises:
        InputError: Unknown name, or a bad file.
        SolutionError: The model does not carry its weight.
    """
    usual = {axis.name: axis.usual for axis in AXES}
    variant = Variant.at(bridge, "contact_friction", {**usual, "skew_deg": 0})
    try:
        with solver_log(None):
            return modal_properties(variant)
    except GravityError as error:
        raise SolutionError(f"{load_bridge(bridge).name}: {error}") from error


def mean_period_s(modes: ModalResult) -> float:
    """Return T1: the geometric mean of the longitudinal and the transverse period.

    Of the model with pads, its gaps open, at zero skew: one number for all variants, because an
    intensity measure that changed with the variant would destroy the pairs.
    """
    return sqrt(modes.period_s("x") * modes.period_s("y"))


def warn_of_periods(bridges: Iterable[str]) -> None:
    """Log a warning for each finding of `periods_of_file` about these bridges.

    Raises:
        InputError: Unknown name, or a bad file.
        SolutionError: A model does not carry its weight.
    """
    for name in dict.fromkeys(bridges):
        for told in periods_of_file(name, standing_bridge(name)):
            logger.warning("%s", told)


def periods_of_file(bridge: str, modes: ModalResult) -> list[str]:
    """Return in words what is doubtful about the conditioning period in the file of a bridge.

    Args:
        bridge: Name, or path of its file.
        modes: Of its model, see `standing_bridge`.
    """
    data, model_s = load_bridge(bridge), mean_period_s(modes)
    told: list[str] = []
    change = data.t1_s / model_s - 1.0
    if abs(change) > TOLERANCE:
        told.append(
            f"{data.name}: t1_s = {data.t1_s:.4g} s is {change:+.1%} off the T1 of its model, "
            f"{model_s:.4g} s; Sa(T1) and Sa_avg of every motion are taken at t1_s: correct it in "
            "the file of the bridge"
        )
    for way, shown in (("x", "longitudinal"), ("y", "transverse")):
        shares = [(float(getattr(mode, f"mass_{way}")), mode.period_s) for mode in modes.modes]
        (first, first_s), (second, second_s), *_ = sorted(shares, reverse=True)
        if second > SHARED * first:
            told.append(
                f"{data.name}: the {shown} motion is shared by modes of {first_s:.3g} s "
                f"({first:.0%} of the mass) and {second_s:.3g} s ({second:.0%}): T1 leaps from one "
                "to the other with small changes of the bridge; Sa(1 s), Sa_avg or PGV say more"
            )
    return told
