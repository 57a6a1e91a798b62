"""How a variant is modelled: the choices that are not data of the bridge."""

from dataclasses import dataclass
from typing import Literal, get_args

from skewbridge.errors import InputError

type Arrays = Literal["rigid", "corotational"]
type ColumnIntegration = Literal["hinge_radau", "lobatto5"]
type Backfill = Literal["hyperbolic", "sdc"]
type KeyKind = Literal["sacrificial", "monolithic"]
type KeyFrame = Literal["skewed", "deck_edge"]
type ShearModel = Literal["sdc", "kowalsky_priestley"]
type Foundation = Literal["fixed", "springs"]
type Coupling = Literal["extrapolated", "lagged"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelOptions:
    """Modelling choices of one analysis; the defaults are the default study's.

    Attributes:
        arrays: Transverse arrays of the abutment: rigid links, or stiff corotational elements as
            in the paper (2.3 times dearer).
        column_integration: ``hinge_radau`` (plastic hinge of the bridge's hinge length) or
            ``lobatto5`` (distributed plasticity as in the paper).
        transverse_gap_m: Gap at each exterior shear key.
        cohesion_n: Cohesion of the backwall contact, total per wall, shared by its points.
        backwall_points: Contact points along a backwall, corners included.
        normal_stiffness_n_per_m: Contact penalty per wall point; None applies the rule of
            `skewbridge.bridge.abutment.penalty`.
        tangent_stiffness_n_per_m: The same for the tangential springs.
        normal_stiffness_factor: Factor on the normal penalty, for studies of its effect.
        tangent_stiffness_factor: The same for the tangential springs.
        wall_dashpot_ratio: Critical damping ratio of the dashpots on wall and key nodes.
        wall_restoring_n_per_m: Weak elastic spring that brings a pushed backwall back, per wall
            at zero skew (reduced like the backfill).
        backfill: Hyperbolic curve or the bilinear one of SDC 2.0.
        backfill_variation: Relative change of backfill strength and stiffness from the middle to
            the ends of a wall skewed at 60 degrees, linear in skew; 0.3 is Kaviani's.
        keys: Sacrificial or monolithic exterior shear keys.
        key_frame: Normal of the keys along the skewed abutment line, or across the deck edge.
        foundation: Column bases on rigid ground, or on the springs of the bridge's file.
        embankment_mass: Whether the critical length of the embankment moves with the abutment
            (`spring` model).
        column_fibers: Rings and wedges of the core, and rings of the cover.
        deck_elements_per_span: Elastic elements per span.
        shear_model: Shear capacity in `column_shear_dcr`: Caltrans criteria (nominal materials,
            displacement ductility), or Kowalsky and Priestley (expected ones, curvature ductility).
        elastic_columns: Cracked elastic columns, for hand checks and modal comparisons.
        coupling: Friction bound of a step from the last committed normal force (``lagged``, as in
            the paper) or from the one predicted at its end. Prediction is the better one where a
            step resolves the contact; with a light wall between deck and soil it does not
            (3 rad of its frequency per 5 ms), and the prediction overshoots: halving the step
            then moves unseating by 2 %, and by less than 1 % with ``lagged``.
    """

    arrays: Arrays = "rigid"
    column_integration: ColumnIntegration = "hinge_radau"
    transverse_gap_m: float = 0.0064  # source: Rahman & Mackie, section 4
    cohesion_n: float = 0.0
    backwall_points: int = 5
    normal_stiffness_n_per_m: float | None = None
    tangent_stiffness_n_per_m: float | None = None
    normal_stiffness_factor: float = 1.0
    tangent_stiffness_factor: float = 1.0
    wall_dashpot_ratio: float = 0.10  # ASSUME light walls radiate: 10 % of critical
    wall_restoring_n_per_m: float = 3.0e5  # ASSUME a pushed backwall comes back slowly: this adds
    # 0.4 % to the backbone at 76 mm, 5e6 would add 7 %
    backfill: Backfill = "hyperbolic"
    backfill_variation: float = 0.0
    keys: KeyKind = "sacrificial"
    key_frame: KeyFrame = "skewed"
    foundation: Foundation = "fixed"
    embankment_mass: bool = False
    column_fibers: tuple[int, int, int] = (8, 20, 2)
    deck_elements_per_span: int = 4
    shear_model: ShearModel = "sdc"
    elastic_columns: bool = False
    coupling: Coupling = "lagged"

    def __post_init__(self) -> None:
        for field, value, choices in (
            ("arrays", self.arrays, Arrays),
            ("column_integration", self.column_integration, ColumnIntegration),
            ("backfill", self.backfill, Backfill),
            ("keys", self.keys, KeyKind),
            ("key_frame", self.key_frame, KeyFrame),
            ("foundation", self.foundation, Foundation),
            ("shear_model", self.shear_model, ShearModel),
            ("coupling", self.coupling, Coupling),
        ):
            allowed = get_args(choices.__value__)
            if value not in allowed:
                raise InputError(
                    f"option {field} must be one of {', '.join(allowed)}, got {value!r}"
                )
        for field, value, low, high in (
            ("transverse_gap_m", self.transverse_gap_m, 0.0, 100.0),
            ("cohesion_n", self.cohesion_n, 0.0, 1.0e9),
            ("backwall_points", self.backwall_points, 2, 41),
            ("normal_stiffness_factor", self.normal_stiffness_factor, 1.0e-3, 1.0e3),
            ("tangent_stiffness_factor", self.tangent_stiffness_factor, 1.0e-3, 1.0e3),
            ("wall_dashpot_ratio", self.wall_dashpot_ratio, 0.0, 1.0),
            ("wall_restoring_n_per_m", self.wall_restoring_n_per_m, 1.0, 1.0e9),
            ("backfill_variation", self.backfill_variation, 0.0, 0.9),
            ("deck_elements_per_span", self.deck_elements_per_span, 1, 64),
            ("column_fibers", min(self.column_fibers), 1, 200),
        ):
            if not low <= value <= high:
                raise InputError(f"option {field} must be within {low:g}..{high:g}, got {value:g}")
        for field, value in (
            ("normal_stiffness_n_per_m", self.normal_stiffness_n_per_m),
            ("tangent_stiffness_n_per_m", self.tangent_stiffness_n_per_m),
        ):
            if value is not None and not value > 0.0:
                raise InputError(f"option {field} must be positive, got {value:g}")
