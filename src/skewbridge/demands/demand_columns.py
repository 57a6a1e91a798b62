"""Columns of intensity measures and demands, with their units, labels and roles."""

from dataclasses import dataclass
from typing import Final, Literal

from skewbridge.demands.completeness import COLUMN_FAILURE_RATIO
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS, ShearModel

type Kind = Literal["text", "integer", "number", "boolean"]
#: What a study does with a demand. ``effect``: paired effects. ``headline``: also needed motions,
#: effects along the intensity, the ranking of measures and a place in the family of verdicts, so
#: that another headline demand may change adjusted verdicts. ``sensitivity``: comparison of the
#: numerics. Curves and clouds belong to limit states (``config/limit_states.yaml``).
type Role = Literal["effect", "headline", "sensitivity"]


@dataclass(frozen=True, slots=True)
class Difference:
    """Absolute judgement of the change of a demand whose values are often near zero.

    Attributes:
        unit: Unit of the difference.
        per_unit: Its units in one unit of the column.
        margin: Difference that counts as negligible, in that unit.
    """

    unit: str
    per_unit: float
    margin: float


@dataclass(frozen=True, slots=True)
class Column:
    """One column of the table.

    Attributes:
        name: Name, with the unit unless it is SI and obvious.
        kind: Type of the values.
        unit: Unit, ``-`` for ratios and texts.
        label: Short name in figures, without unit.
        symbol: Mathematical symbol.
        description: What the number is, with its sign.
        roles: What a study does with it.
        difference: How its change is judged if not by the ratio.
    """

    name: str
    kind: Kind = "number"
    unit: str = "-"
    label: str = ""
    symbol: str = ""
    description: str = ""
    roles: tuple[Role, ...] = ()
    difference: Difference | None = None

    @property
    def label_with_unit(self) -> str:
        """Label of a figure axis."""
        text = self.label or self.name.replace("_", " ")
        return text if self.unit == "-" else f"{text} ({self.unit})"


# ASSUME 5 mm at an abutment, a fifth of a narrow joint, is below what a designer would act on;
# a rotation of 0.1 mrad moves the end of a deck of 90 m by as much
_TURN: Final = Difference("mrad", 1e3, 0.1)
_PUSH: Final = Difference("mm", 1e3, 5.0)

#: Names of the models of the shear capacity of columns.
SHEAR_MODELS: Final[dict[ShearModel, str]] = {
    "sdc_expected": "SDC, expected materials",
    "sdc_nominal": "SDC, nominal materials",
    "kowalsky_priestley": "Kowalsky and Priestley",
}

# fmt: off
INTENSITY_COLUMNS: Final = (
    Column("im_pga_rotd50_g", unit="g", label="PGA RotD50",
           description="peak ground acceleration, RotD50"),
    Column("im_pgv_rotd50_mps", unit="m/s", label="PGV RotD50",
           description="peak ground velocity, RotD50"),
    Column("im_sa_t1_rotd50_g", unit="g", label="$S_a(T_1)$ RotD50",
           description="5 % PSA at the bridge's conditioning T1, RotD50"),
    Column("im_sa_1p000_rotd50_g", unit="g", label=r"$S_a(1.0\,\mathrm{s})$ RotD50",
           description="5 % PSA at 1.0 s, RotD50"),
    Column("im_saavg_rotd50_g", unit="g", label=r"$S_{a,\mathrm{avg}}$ RotD50",
           description="geometric mean of PSA RotD50 at 20 periods from 0.2 T1 to 3 T1"),
    Column("im_arias_mps", unit="m/s", label="Arias intensity",
           description="Arias intensity"),
    Column("im_cav_mps", unit="m/s", label="CAV",
           description="cumulative absolute velocity"),
    Column("im_d5_75_s", unit="s", label="$D_{5-75}$",
           description="significant duration, 5 to 75 % of Arias intensity"),
    Column("im_d5_95_s", unit="s", label="$D_{5-95}$",
           description="significant duration, 5 to 95 % of Arias intensity"),
)

DEMAND_COLUMNS: Final = (
    Column("column_shear_x_kn", unit="kN", label="Column shear, longitudinal", symbol="V_x",
           description="peak longitudinal shear of a column's section, V + P theta"),
    Column("column_shear_y_kn", unit="kN", label="Column shear, transverse", symbol="V_y",
           description="peak transverse shear of a column's section, V + P theta"),
    Column("column_shear_kn", unit="kN", label="Column shear", symbol="V",
           description="peak resultant shear of a column's section, V + P theta",
           roles=("effect", "sensitivity")),
    Column("column_base_shear_kn", unit="kN", label="Column base force", symbol="V_b",
           description="peak resultant force at a column base, without P theta"),
    Column("column_shear_dcr", label="Column shear demand/capacity", symbol="V/V_c",
           description="peak of the section's shear over its ductility-dependent capacity",
           roles=("effect", "headline")),
    *(
        Column(SHEAR_MODEL_DEMANDS[model], label=f"Column shear demand/capacity, {text}",
               description=f"the same, {text}, over the whole history: also after a column failed")
        for model, text in SHEAR_MODELS.items()
    ),
    Column("column_drift_ratio", label="Column drift ratio", symbol=r"\delta",
           description="peak resultant drift over clear height",
           roles=("effect", "headline", "sensitivity")),
    Column("drift_over_capacity", label="Drift over capacity", symbol=r"\delta/\delta_c",
           description="peak drift over the SDC displacement capacity of its bent",
           roles=("effect",)),
    Column(COLUMN_FAILURE_RATIO, label="Column demand over capacity",
           description="larger of column_shear_dcr, drift_over_capacity; a column fails at 1"),
    Column("column_curvature_ductility", label="Curvature ductility", symbol=r"\mu_\phi",
           description="peak curvature over yield curvature", roles=("effect",)),
    Column("column_residual_drift_ratio", label="Residual drift ratio", symbol=r"\delta_r",
           description="resultant drift at rest after the run; for a collapsed or failed run, "
           "the drift at its last step", roles=("effect",)),
    Column("deck_disp_x_m", unit="m", label="Deck displacement, longitudinal", symbol="u_x",
           description="peak longitudinal displacement at the mass centre", roles=("effect",)),
    Column("deck_disp_y_m", unit="m", label="Deck displacement, transverse", symbol="u_y",
           description="peak transverse displacement at the mass centre", roles=("effect",)),
    Column("deck_disp_m", unit="m", label="Deck displacement", symbol="u",
           description="peak resultant displacement at the mass centre",
           roles=("effect", "headline", "sensitivity")),
    Column("deck_rotation_rad", unit="rad", label="Deck rotation", symbol=r"\theta",
           description="peak rotation of the deck about the vertical",
           roles=("effect", "sensitivity"), difference=_TURN),
    Column("deck_accel_mps2", unit="m/s2", label="Deck acceleration", symbol="a",
           description="peak resultant total acceleration of the deck"),
    Column("abutment_passive_m", unit="m", label="Abutment, passive", symbol="u_p",
           description="peak push of the backwall into the fill, excluding the gap",
           roles=("effect", "sensitivity"), difference=_PUSH),
    Column("abutment_active_m", unit="m", label="Abutment, active", symbol="u_a",
           description="peak movement of the backwall away from the fill; nothing pulls it, so no "
           "limit state uses it", difference=_PUSH),
    Column("abutment_transverse_m", unit="m", label="Abutment, transverse", symbol="u_t",
           description="peak transverse movement of the abutment", roles=("effect",),
           difference=_PUSH),
    Column("bearing_disp_m", unit="m", label="Bearing deformation", symbol="u_b",
           description="peak resultant shear deformation of a bearing", roles=("effect",)),
    Column("bearing_uplift_m", unit="m", label="Bearing uplift", symbol="u_z",
           description="largest opening between deck and pads, which take no tension"),
    Column("unseating_m", unit="m", label="Unseating", symbol="u_s",
           description="peak outward move off the seat, normal to it, any corner",
           roles=("effect", "headline", "sensitivity")),
    Column("acute_corner_unseating_m", unit="m", label="Unseating, acute corners", symbol="u_{s,a}",
           description="the same at the acute corners of the deck"),
    Column("shear_key_force_kn", unit="kN", label="Shear key force", symbol="F_k",
           description="peak force of a shear key that the deck touches",
           roles=("effect", "sensitivity")),
    Column("shear_key_disp_m", unit="m", label="Shear key deformation", symbol="u_k",
           description="peak deformation of a shear key along its normal, excluding the gap",
           roles=("effect",)),
    Column("backwall_force_kn", unit="kN", label="Backwall force", symbol="F_w",
           description="peak force that the deck passes through one backwall",
           roles=("effect", "sensitivity")),
    Column("friction_force_kn", unit="kN", label="Friction force", symbol="F_f",
           description="peak friction force on one backwall or key",
           roles=("sensitivity",)),
    Column("contact_force_ratio", label="Contact force over weight",
           description="peak normal force of one contact unit over the weight of the bridge"),
    Column("contact_closures", label="Contact closures", symbol="n_c",
           description="closures of all contact units; each rattle is counted, so the number "
           "depends on the time step"),
    Column("contact_time_s", unit="s", label="Contact time", symbol="t_c",
           description="time that some contact unit was closed, summed"),
    Column("contact_max_penetration_m", unit="m", label="Contact penetration", symbol="u_n",
           description="peak penetration of a contact unit"),
    Column("friction_impulse_kns", unit="kN s", label="Friction impulse", symbol="J_f",
           description="friction force times time, summed over all contacts",
           roles=("sensitivity",)),
    Column("slip_work_kj", unit="kJ", label="Slip work", symbol="W_f",
           description="work of friction, dissipated", roles=("sensitivity",)),
    Column("friction_after_opening_ratio", label="Friction work in opening steps",
           description="share of the friction work in steps in which a contact opened"),
    Column("cone_violation_ratio", label="Excess over the friction cone",
           description="largest excess over the local friction limit, over the largest limit"),
    Column("cone_excess_wall_ratio", label="Excess work, backwalls",
           description="share of the friction work on backwalls above the local limit"),
    Column("cone_excess_key_ratio", label="Excess work, keys",
           description="share of the friction work on keys above the local limit"),
    *(
        Column(f"cone_{kind}_over_{percent}pct_ratio", label=f"{percent} % over, {kind}",
               description=f"share of the {whole} with friction {percent} % and more above the "
               "local limit")
        for kind, whole in (("work", "friction work"), ("time", "contact time"))
        for percent in (1, 10, 50)
    ),
    Column("energy_residual_ratio", label="Energy residual",
           description="energy not accounted for, over the input"),
    Column("numerical_dissipation_ratio", label="Numerical dissipation",
           description="energy that the integrator dissipates, over the input; negative: makes"),
    Column("contact_energy_ratio", label="Energy kept by contacts",
           description="energy dissipated in normal springs of contacts, over the input; "
           "negative: made"),
)
# fmt: on
