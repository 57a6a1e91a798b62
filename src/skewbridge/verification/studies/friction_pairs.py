"""What the studies of friction share: OSB1 with friction and without, drawn side by side."""

from collections.abc import Callable, Mapping
from typing import Final

from matplotlib.axes import Axes

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings, Scheme
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.paper_motions import PaperMotion

type Curve = tuple[Array, Array]

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


def analysis(variant: Variant, motion: PaperMotion, scheme: Scheme = "default") -> AnalysisResult:
    """Return the analysis of a bridge under a motion, with its histories."""
    settings = AnalysisSettings(scheme=scheme, duration_s=DURATION_S)
    excitation = Excitation(motion=motion.motion)
    return analyse(variant, excitation, settings, ModelOptions(), histories=True)


def histories_of(result: AnalysisResult) -> Mapping[str, Array]:
    """Return the histories of a result that was asked for them."""
    return result.histories or {}


def stick_slip_changes(
    normal_n: Array, friction_n: Array, coefficient: float, *, near_limit: float = 0.98
) -> int:
    """Return how often closed contacts go from sticking to slipping or back.

    The normal forces and the resultants of friction have the shape (n, units); what counts as
    slipping is a share of the limit.
    """
    closed = normal_n > 0.0
    slipping = friction_n >= near_limit * coefficient * normal_n
    stays = closed[1:] & closed[:-1]
    return int((stays & (slipping[1:] != slipping[:-1])).sum())


def draw_pair(axis: Axes, with_friction: Curve, without: Curve) -> None:
    """Draw the two curves of a pair, the one with friction on top."""
    style.line(axis, *without, style.ORANGE, "no friction", lw=0.8)
    style.line(axis, *with_friction, style.BLUE, "friction 0.5")
