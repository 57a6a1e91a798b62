"""Check of a bridge before a study: weight, periods, capacities and doubtful properties."""

from collections import Counter
from dataclasses import dataclass
from math import inf
from typing import Any, Final

from skewbridge.analysis.modal import (
    ModalResult,
    conditioning_period_s,
    periods_of_file,
    standing_bridge,
)
from skewbridge.analysis.sdc import capacity_rows
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.bridge.section import sdc_shear_strength
from skewbridge.units import KN, MPA

#: Largest axial force under dead load over the expected strength of the gross section.
#: source: AASHTO Guide Specifications for LRFD Seismic Bridge Design, 8.7.2, ductile columns
AXIAL_LOAD_LIMIT: Final = 0.2
DIRECTIONS: Final = {"x": "longitudinal", "y": "transverse", "z": "vertical", "rz": "in plan"}


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeCheck:
    """A bridge under dead load with open gaps, at zero skew: weight, reactions, modes.

    Attributes:
        bents: A row per bent with loads and capacities of one of its columns.
        findings: Properties that would cause trouble in a study, one sentence each.
    """

    bridge: BridgeData
    standing: ModalResult
    bents: tuple[dict[str, Any], ...]
    findings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """Return weight, reactions, periods and the sources of the numbers by name."""
        left, right = self.standing.abutment_reaction_kn
        kinds = Counter(source.split(":", 1)[0] for source in self.bridge.sources.values())
        return {
            "bridge": self.bridge.name,
            "title": self.bridge.title,
            "length_m": self.bridge.length_m,
            "weight_kn": self.standing.weight_kn,
            "reaction_left_kn": left,
            "reaction_right_kn": right,
            **{
                f"period_{direction}_s": self.standing.period_s(direction)
                for direction in DIRECTIONS
            },
            "t1_of_the_model_s": conditioning_period_s(self.standing),
            "t1_of_the_file_s": self.bridge.t1_s,
            "sources": ", ".join(f"{kinds[kind]} {kind}" for kind in sorted(kinds)),
        }


def check_bridge(name: str) -> BridgeCheck:
    """Build a bridge by its name or file, apply its dead load and check it."""
    data, standing = load_bridge(name), standing_bridge(name)
    bents = tuple(_bent_row(data, row) for row in capacity_rows(data))
    findings = [finding for row in bents for finding in _bent_findings(row)]
    for direction, adjective in DIRECTIONS.items():
        if standing.period_s(direction) == inf:
            findings.append(f"nothing holds the bridge {adjective}: its period is infinite")
    for side, force_kn in zip(("left", "right"), standing.abutment_reaction_kn, strict=True):
        if force_kn <= 0.0:
            findings.append(f"the deck lifts off the {side} abutment under dead load")
    findings += periods_of_file(name, standing)
    return BridgeCheck(bridge=data, standing=standing, bents=bents, findings=tuple(findings))


def _bent_row(bridge: BridgeData, row: dict[str, Any]) -> dict[str, Any]:
    """Return the capacities of a bent with axial load ratio and shear of one of its columns."""
    column, bent = bridge.column, bent_capacity(bridge, row["bent"] - 1)
    strength_kn = column.expected_concrete_strength_mpa * MPA * column.gross_area_m2 / KN
    ductility = bent.capacity_m / bent.yield_disp_m
    shear_n = sdc_shear_strength(bent.shear, bent.axial_n, ductility)
    return {
        "bent": row["bent"],
        "axial_kn": row["axial_kn"],
        "axial_load_ratio": row["axial_kn"] / strength_kn,
        "axial_load_limit": AXIAL_LOAD_LIMIT,
        "plastic_moment_knm": row["plastic_moment_knm"],
        "plastic_shear_kn": row["plastic_moment_knm"] / bent.shear_span_m,
        "shear_strength_kn": float(shear_n) / KN,
        "yield_disp_m": row["yield_disp_m"],
        "disp_capacity_m": row["capacity_m"],
        "p_delta_ratio": row["p_delta_ratio"],
        "p_delta_limit": row["p_delta_limit"],
    }


def _bent_findings(row: dict[str, Any]) -> list[str]:
    findings: list[str] = []
    if row["axial_load_ratio"] > row["axial_load_limit"]:
        findings.append(
            f"bent {row['bent']}: axial load ratio {row['axial_load_ratio']:.3f} is above "
            f"{row['axial_load_limit']:g} (AASHTO Guide Specifications 8.7.2)"
        )
    if row["plastic_shear_kn"] > row["shear_strength_kn"]:
        findings.append(
            f"bent {row['bent']}: the plastic shear of a column, {row['plastic_shear_kn']:.0f} kN, "
            f"is above its strength at the displacement capacity, {row['shear_strength_kn']:.0f} "
            "kN (SDC 3.6): it fails in shear before its hinges have turned"
        )
    if row["p_delta_ratio"] > row["p_delta_limit"]:
        findings.append(
            f"bent {row['bent']}: P-Delta ratio {row['p_delta_ratio']:.2f} at the displacement "
            f"capacity is above {row['p_delta_limit']:g} (SDC 4.2)"
        )
    return findings
