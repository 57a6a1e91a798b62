"""Weights, periods and strengths of the catalogue's models against hand values and other models.

Each row of `bridge_values.csv` is a reference for a bridge, abutment, section state, direction or
angle (`at`) and final displacement of a push (`end_m`). The sources are *hand* (engineering rules),
*PyPBEE* (the public models of Kaviani's bridges) and *this project's earlier model* (a fiber model
of the same data with the named section state). The last shows whether the model has changed, not
whether it is right.
"""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.modal import ModalResult, modal_properties, modes_of
from skewbridge.analysis.pushover import push_abutment, push_bridge
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import BentCapacity, bent_capacity, shear_section
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import sdc_shear_strength, section_response
from skewbridge.bridge.weights import column_axial_n, total_weight_n
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import Study
from skewbridge.verification.statements import records_in
from skewbridge.verification.studies.paper_runs import paper_variant

STATES: Final = {
    "cracked elastic": ModelOptions(elastic_columns=True, foundation="fixed"),
    # the reference models are on rigid ground and load the bent caps in the middle
    "hinge": ModelOptions(cap_load="middle", foundation="fixed"),
    "fiber": ModelOptions(column_integration="lobatto5", cap_load="middle", foundation="fixed"),
}

type Values = Mapping[str, str]
"""A row of the table."""

_TABLE: Final = records_in(Path(__file__).parents[1] / "bridge_values.csv")
_AXIAL: Final = "base axial force (kN)"


def run(study: Study) -> None:
    """Compare all rows of the table, and hand values of weights and axial forces of A to C."""
    for row in _TABLE:
        quantity, _, unit = row["quantity"].partition(" (")
        words = (f"{row['bridge']} {quantity} {row['at']}".strip(), row["abutment"], row["state"])
        name = f"{', '.join(filter(None, words))} ({unit}"
        found = COMPUTED[row["quantity"]](row)
        numbers = float(row["reference"]), float(row["tolerance"])
        study.relative(name, found, *numbers, row["source"])
    for bridge in ("bridge_a", "bridge_b", "bridge_c"):
        by_hand = total_weight_n(load_bridge(bridge)) / KN
        found = _modes(bridge, "contact", "hinge").weight_kn
        study.relative(f"{bridge} weight (kN)", found, by_hand, 0.01, "hand")
    axial = _modes("bridge_c", "roller", "hinge").column_axial_kn
    for number in (0, 1):
        mean = sum(axial[3 * number : 3 * number + 3]) / 3
        by_hand = column_axial_n(load_bridge("bridge_c"), number) / KN
        name = f"bridge_c mean base axial force, bent {number + 1} (kN)"
        study.relative(name, mean, by_hand, 0.01, "hand, three moments")


@cache
def _modes(bridge: str, abutment: str, state: str) -> ModalResult:
    return modal_properties(paper_variant(bridge=bridge, abutment=abutment), STATES[state])


def _modes_of_row(row: Values) -> ModalResult:
    return _modes(row["bridge"], row["abutment"], row["state"])


def _bent(row: Values) -> BentCapacity:
    return bent_capacity(load_bridge(row["bridge"]), 0)


def _held_period_s(row: Values) -> float:
    """Return the transverse period (s) with both deck ends fixed transversely."""
    with domain():
        variant = paper_variant(bridge=row["bridge"], abutment=row["abutment"])
        model = build(variant, STATES[row["state"]])
        stiff = model.tags.material()
        ops.uniaxialMaterial("Elastic", stiff, 1.0e12)
        for bearing in (each for abutment in model.abutments for each in abutment.bearings):
            nodes = (model.tags.element(), bearing.seat_node, bearing.deck_node)
            ops.element("zeroLength", *nodes, "-mat", stiff, "-dir", 2)
        modes = modes_of(model, 12)
    return max(modes, key=lambda mode: mode.mass_y).period_s


def _pushed_kn(row: Values) -> float:
    """Return the strength (kN) of a bridge pushed at an angle."""
    variant = paper_variant(bridge=row["bridge"], abutment=row["abutment"])
    push = {"angle_deg": float(row["at"]), "max_disp_m": float(row["end_m"])}
    return push_bridge(variant, STATES[row["state"]], **push, steps=60).peak_n / KN


def _shear_strength_kn(row: Values) -> float:
    """Return the shear strength (kN) of a column at ductility 5, under the table's axial force."""
    data = load_bridge(row["bridge"])
    axials = {each["bridge"]: each["reference"] for each in _TABLE if each["quantity"] == _AXIAL}
    axial_n = float(axials[row["bridge"]]) * KN
    curve = section_response(data.column, axial_n)
    shear = shear_section(data.column, data.bents[0].clear_height_m, curve)
    return float(sdc_shear_strength(shear, axial_n, 5.0)) / KN


def _passive_kn(row: Values) -> float:
    """Return the force (kN) of a backfill pushed normal to its wall, without the pad forces."""
    end_m = float(row["end_m"])
    pads = load_bridge(row["bridge"]).seats["right"].pads
    ratio, shear_kn_per_m = pads.hardening_ratio, pads.shear_stiffness_kn_per_m
    plastic_kn = min((1 - ratio) * shear_kn_per_m * end_m, pads.yield_force_kn)
    pads_kn = pads.count * (plastic_kn + ratio * shear_kn_per_m * end_m)
    curve = push_abutment(
        paper_variant(bridge=row["bridge"], skew_deg=int(row["at"])),
        # a push normal to the wall never closes keys square to it: only backfill and pads act
        ModelOptions(backfill="sdc", key_frame="skewed"),
        angle_deg=float(row["at"]),
        max_disp_m=end_m,
        steps=180,
    )
    return curve.force_n[-1] / KN - pads_kn


COMPUTED: Final[Mapping[str, Callable[[Values], float]]] = {
    "weight (kN)": lambda row: _modes_of_row(row).weight_kn,
    _AXIAL: lambda row: _modes_of_row(row).column_axial_kn[0],
    "period (s)": lambda row: _modes_of_row(row).period_s(row["at"]),
    "period, ends held (s)": _held_period_s,
    "pushover strength (kN)": _pushed_kn,
    "plastic moment (MNm)": lambda row: _bent(row).curve.plastic_moment_nm / 1e6,
    "displacement capacity (m)": lambda row: _bent(row).capacity_m,
    "shear strength at ductility 5 (kN)": _shear_strength_kn,
    "passive force (kN)": _passive_kn,
}
