"""What the studies of friction share: OSB1 with friction and without, drawn side by side."""

from collections.abc import Callable
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from skewbridge.variant.variant import Variant
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.figure_style import line

type Series = NDArray[np.float64]
type Curve = tuple[Series, Series]

FRICTION_PCT: Final = 50  # source: the paper, section 4
GAP_MM: Final = 51  # source: the paper, section 4
DURATION_S: Final = 25.0


def paper_variant(
    *,
    bridge: str = "osb1",
    abutment: str = "contact_friction",
    skew_deg: int = 0,
    friction_pct: int = FRICTION_PCT,
) -> Variant:
    """Return a variant with the paper's gap, and its friction unless another is given."""
    return Variant(
        bridge=bridge,
        abutment=abutment,
        skew_deg=skew_deg,
        gap_mm=GAP_MM,
        friction_pct=friction_pct,
    )


def with_and_without[Result](
    run: Callable[[Variant], Result], *, bridge: str = "osb1", skew_deg: int = 0
) -> tuple[Result, Result]:
    """Return what a function gives for a bridge with the paper's friction and without."""
    with_friction = run(paper_variant(bridge=bridge, skew_deg=skew_deg))
    return with_friction, run(paper_variant(bridge=bridge, skew_deg=skew_deg, friction_pct=0))


def stick_slip_changes(
    normal_n: Series, friction_n: Series, coefficient: float, *, near_limit: float = 0.98
) -> int:
    """Return how often closed contacts go from sticking to slipping or back.

    Args:
        normal_n: Normal forces, shape (n, units).
        friction_n: Friction forces, resultant, shape (n, units).
        coefficient: Coulomb coefficient.
        near_limit: Share of the limit that counts as slipping.
    """
    closed = normal_n > 0.0
    slipping = friction_n >= near_limit * coefficient * normal_n
    stays = closed[1:] & closed[:-1]
    return int((stays & (slipping[1:] != slipping[:-1])).sum())


def draw_pair(axis: Axes, with_friction: Curve, without: Curve) -> None:
    """Draw the two curves of a pair, the one with friction on top."""
    line(axis, *without, style.ORANGE, "no friction", lw=0.8)
    line(axis, *with_friction, style.BLUE, "friction 0.5")
