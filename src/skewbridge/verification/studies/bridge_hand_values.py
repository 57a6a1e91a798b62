"""The catalogue's models against hand values and other models: weights, periods, strengths.

Sources of the references, as named in the rows: *hand*, by engineering rules; *PyPBEE*, the public
models of Kaviani's bridges; *this project's earlier model*, a fiber model of the same data with the
named section state, which shows whether the model has changed, not whether it is right.
"""

from functools import cache
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.modal import ModalResult, modal_properties, modes_of
from skewbridge.analysis.pushover import push_abutment, push_bridge
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity, shear_section
from skewbridge.bridge.gravity import column_axial_n, total_weight_n
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import section_response
from skewbridge.bridge.shear_capacity import sdc_shear_strength
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import EARLIER_MODEL, Study
from skewbridge.verification.studies.paper_runs import paper_variant

STATES: Final = {
    "cracked elastic": ModelOptions(elastic_columns=True),
    # the reference models apply the deck's load in the middle of the caps
    "hinge": ModelOptions(cap_load="middle"),
    "fiber": ModelOptions(column_integration="lobatto5", cap_load="middle"),
}
_PADS_ONLY: Final = f"{EARLIER_MODEL}, pads only"
_COUPLED: Final = f"{EARLIER_MODEL}, coupled with 0.638"
# bridge, abutment, section state, periods in s by direction, source
PERIODS: Final = (
    ("osb1", "roller", "cracked elastic", {"x": 0.937, "y": 0.778}, EARLIER_MODEL),
    ("osb1", "roller", "hinge", {"x": 0.893, "y": 0.745}, EARLIER_MODEL),
    ("osb1", "roller", "fiber", {"x": 0.839, "y": 0.679}, EARLIER_MODEL),
    ("osb1", "contact", "fiber", {"x": 0.788, "y": 0.622}, _PADS_ONLY),
    ("osb1", "contact", "fiber", {"rz": 1.024}, f"{_PADS_ONLY}; 1.029 by hand"),
    ("osb1", "roller", "hinge", {"z": 0.388}, EARLIER_MODEL),
    ("osb1_fixed", "roller", "cracked elastic", {"x": 0.368}, _COUPLED),
    ("osb1_fixed", "roller", "cracked elastic", {"y": 0.467}, EARLIER_MODEL),
    ("osb2s", "roller", "cracked elastic", {"x": 2.50, "y": 2.45}, EARLIER_MODEL),
    ("osb2s", "roller", "hinge", {"x": 2.25, "y": 2.25}, EARLIER_MODEL),
    ("osb2s", "roller", "fiber", {"x": 1.76, "y": 1.94}, EARLIER_MODEL),
    ("osb2s", "contact", "fiber", {"x": 1.50, "y": 1.61, "rz": 1.38}, _PADS_ONLY),
    ("bridge_a", "contact", "fiber", {"x": 0.610}, "PyPBEE as it is (keys act across only)"),
    ("bridge_b", "roller", "fiber", {"x": 1.04, "y": 1.04}, "PyPBEE, pinned base"),
    ("bridge_b", "contact", "fiber", {"x": 0.856, "y": 0.841}, "PyPBEE, pads only"),
)
STIFF_N_PER_M: Final = 1.0e12  # holds a deck end
WEIGHTS_KN: Final = {"osb1": 19_054.0, "osb2s": 37_208.0}
AXIAL_KN: Final = {
    "osb1": (5_997.0, EARLIER_MODEL),
    "osb2s": (7_513.0, EARLIER_MODEL),
    "bridge_a": (8_878.0, "PyPBEE"),
    "bridge_b": (8_769.0, "PyPBEE, pinned base"),
}
# bridge, section state, displacement in m where the push ends, strengths in kN by direction in deg
PUSHES: Final = (
    ("osb1", "hinge", 0.20, {0.0: 5_786.0, 90.0: 5_730.0}),
    ("osb1", "fiber", 0.14, {0.0: 6_031.0, 90.0: 5_882.0}),
    ("osb1_fixed", "hinge", 0.12, {0.0: 12_150.0}),
    ("osb2s", "hinge", 0.60, {0.0: 4_345.0, 90.0: 4_322.0}),
)
PASSIVE_KN: Final = {
    "osb1": {0: 6_662.0, 30: 3_420.0, 60: 1_756.0},
    "osb2s": {0: 10_024.0, 30: 5_147.0, 60: 2_642.0},
}


def run(study: Study) -> None:
    """Compare all values that the catalogue's sources give."""
    _dead_load(study)
    for bridge, abutment, state, periods_s, source in PERIODS:
        for direction, period_s in periods_s.items():
            found = _modes(bridge, abutment, state).period_s(direction)
            name = f"{bridge} period {direction}, {abutment}, {state} (s)"
            study.relative(name, found, period_s, 0.05, source)
    source = "PyPBEE as it is: keys without a gap, of a stiffness not given, hold the ends"
    held_s = _held_period_s("bridge_a", STATES["fiber"])
    study.relative("bridge_a period y, ends held, fiber (s)", held_s, 0.374, 0.05, source)
    for bridge, state, end_m, strengths_kn in PUSHES:
        variant = paper_variant(bridge=bridge, abutment="roller")
        for angle, strength_kn in strengths_kn.items():
            curve = push_bridge(variant, STATES[state], angle_deg=angle, max_disp_m=end_m, steps=60)
            name = f"{bridge} pushover at {angle:g} degrees, {state} (kN)"
            study.relative(name, curve.peak_n / KN, strength_kn, 0.05, EARLIER_MODEL)
    _capacities(study)
    _backbones(study)


def _dead_load(study: Study) -> None:
    others = ("bridge_a", "bridge_b", "bridge_c")
    weights_kn = {bridge: total_weight_n(load_bridge(bridge)) / KN for bridge in others}
    for bridge, weight_kn in (WEIGHTS_KN | weights_kn).items():
        found = _modes(bridge, "contact", "hinge").weight_kn
        study.relative(f"{bridge} weight (kN)", found, weight_kn, 0.01, "hand")
    for bridge, (axial_kn, source) in AXIAL_KN.items():
        found = _modes(bridge, "roller", "hinge").column_axial_kn[0]
        study.relative(f"{bridge} base axial force (kN)", found, axial_kn, 0.01, source)
    axial = _modes("bridge_c", "roller", "hinge").column_axial_kn
    for number in (0, 1):
        mean = sum(axial[3 * number : 3 * number + 3]) / 3
        by_hand = column_axial_n(load_bridge("bridge_c"), number) / KN
        name = f"bridge_c mean base axial force, bent {number + 1} (kN)"
        study.relative(name, mean, by_hand, 0.01, "hand, three moments")


def _capacities(study: Study) -> None:
    for bridge, plastic_mnm, capacity_m, strength_kn in (
        ("osb1", 17.01, 0.211, 4_965.0),
        ("osb2s", 17.82, 0.908, 5_548.0),
    ):
        data = load_bridge(bridge)
        bent = bent_capacity(data, 0)
        name = f"{bridge} plastic moment (MNm)"
        study.relative(name, bent.curve.plastic_moment_nm / 1e6, plastic_mnm, 0.02, EARLIER_MODEL)
        name = f"{bridge} displacement capacity (m)"
        study.relative(name, bent.capacity_m, capacity_m, 0.05, "hand, SDC 1.7")
        axial_n = AXIAL_KN[bridge][0] * KN
        curve = section_response(data.column, axial_n)
        shear = shear_section(data.column, data.bents[0].clear_height_m, curve)
        found = float(sdc_shear_strength(shear, axial_n, 5.0)) / KN
        name = f"{bridge} shear strength at ductility 5 (kN)"
        study.relative(name, found, strength_kn, 0.005, "hand, SDC 1.7")


def _backbones(study: Study) -> None:
    """Push one abutment normal to its wall, past the gap and the bilinear backfill's yield."""
    end_m = 0.09
    for bridge, forces in PASSIVE_KN.items():
        pads = load_bridge(bridge).abutment.pads
        ratio, shear_kn_per_m = pads.hardening_ratio, pads.shear_stiffness_kn_per_m
        plastic_kn = min((1 - ratio) * shear_kn_per_m * end_m, pads.yield_force_kn)
        pads_kn = pads.count * (plastic_kn + ratio * shear_kn_per_m * end_m)
        for skew_deg, force_kn in forces.items():
            curve = push_abutment(
                paper_variant(bridge=bridge, skew_deg=skew_deg),
                # a push normal to the wall never meets keys square to it: backfill and pads alone
                ModelOptions(backfill="sdc", key_frame="skewed"),
                angle_deg=float(skew_deg),
                max_disp_m=end_m,
                steps=180,
            )
            found = curve.force_n[-1] / KN - pads_kn
            name = f"{bridge} passive force at skew {skew_deg} degrees (kN)"
            study.relative(name, found, force_kn, 0.005, "hand, SDC 2.0")


@cache
def _modes(bridge: str, abutment: str, state: str) -> ModalResult:
    return modal_properties(paper_variant(bridge=bridge, abutment=abutment), STATES[state])


def _held_period_s(bridge: str, options: ModelOptions) -> float:
    """Return the transverse period with both deck ends held across."""
    with domain():
        model = build(paper_variant(bridge=bridge, abutment="contact"), options)
        stiff = model.tags.material()
        ops.uniaxialMaterial("Elastic", stiff, STIFF_N_PER_M)
        for abutment in model.abutments:
            for bearing in abutment.bearings:
                nodes = (model.tags.element(), bearing.seat_node, bearing.deck_node)
                ops.element("zeroLength", *nodes, "-mat", stiff, "-dir", 2)
        modes = modes_of(model, 12)
    return max(modes, key=lambda mode: mode.mass_y).period_s
