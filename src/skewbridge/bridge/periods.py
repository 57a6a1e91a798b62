"""Periods of a bridge of the catalogue from a linear frame, without OpenSees.

They agree with those of the OpenSees model within 0.5 %; a bridge file that does not give its
conditioning and damping periods has these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import pi, sqrt
from typing import Any, Final, Literal

import numpy as np

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.column import bent_directions
from skewbridge.bridge.section import FloatArray, shear_modulus_pa
from skewbridge.bridge.weights import column_weight_n, spine_points_m
from skewbridge.units import G_MPS2, GPA, KN, MN

type Place = tuple[float, float, float]
#: ``pads``: columns under dead load, and pads. ``roller``: cracked columns and ends that are held
#: only vertically; with ``held`` also transversely.
type Supports = Literal["pads", "roller", "held"]

ELEMENTS_PER_SPAN: Final = 8
_X, _Y = np.eye(3)[:2]
_RIGID: Final = 1.0e3  # factor on stiffnesses of a cap that the webs prevent from bending


def bridge_period_s(bridge: BridgeData, which: Literal["t1", "long", "short"]) -> float:
    """Return the conditioning period, or the long or short period of Rayleigh damping, in s.

    A bridge without columns has no longitudinal stiffness without its pads. Raises `ValueError`
    for a bridge with inner joints or without two seats.
    """
    if which == "t1":
        periods = frame_periods_s(bridge, "pads")
        return sqrt(periods["x"] * periods["y"])
    if which == "long":
        periods = frame_periods_s(bridge, "roller" if bridge.bents else "pads")
        return max(periods["x"], periods["y"])
    periods = frame_periods_s(bridge, "held" if bridge.bents else "pads")
    return min(periods["y"], periods["z"])


def frame_periods_s(bridge: BridgeData, supports: Supports) -> dict[str, float]:
    """Return the period of the mode with the most mass along x, y and z: open joints, no skew."""
    if bridge.joints or len(bridge.seats) < 2:
        raise ValueError("the frame has no inner joints and two seats")
    frame, deck, pads = _Frame(), bridge.deck, bridge.seat.pads
    (points,) = spine_points_m(bridge, ELEMENTS_PER_SPAN)
    spine = [frame.node((x, 0.0, deck.centroid_above_soffit_m)) for x in points]
    modulus = deck.elastic_modulus_gpa * GPA
    torsion_nm2 = shear_modulus_pa(modulus) * deck.torsion_constant_m4
    bending = modulus * deck.inertia_transverse_m4, modulus * deck.inertia_vertical_m4
    for ends in pairwise(spine):
        frame.beam(ends, (modulus * deck.area_m2, torsion_nm2, *bending), _Y)
    for node, length_m in zip(spine, points.values(), strict=True):
        weight_n = deck.line_load_kn_per_m * KN * length_m
        weight_n += deck.diaphragm_weight_kn * KN * (node in (spine[0], spine[-1]))
        across, upright = weight_n * deck.width_m**2 / 12, weight_n * deck.depth_m**2 / 12
        frame.add_weight(node, weight_n, (across + upright, upright, across))
    positions = np.array(list(points))
    for number, x in enumerate(bridge.bent_positions_m):
        centre = spine[int(np.abs(positions - x).argmin())]
        _add_bent(frame, bridge, number, centre, is_cracked=supports != "pads")
    has_pads = supports == "pads"
    shear = pads.count * pads.shear_stiffness_kn_per_m * KN if has_pads else 0.0
    springs = np.diag([shear, shear, pads.count * pads.vertical_stiffness_mn_per_m * MN]) / 2
    arm_m = pads.spacing_m * sqrt((pads.count**2 - 1) / 12) if has_pads else deck.width_m / 2
    for node in (spine[0], spine[-1]):
        for y in (-arm_m, arm_m):
            reach = np.hstack((np.eye(3), _turned((0.0, y, -deck.centroid_above_soffit_m))))
            frame.add([node], reach.T @ springs @ reach)
        if supports == "held":
            frame.fixed.append(6 * node + 1)
    return frame.periods_s()


def _add_bent(
    frame: "_Frame", bridge: BridgeData, number: int, centre: int, *, is_cracked: bool
) -> None:
    """Add cap, columns and bases of a bent below a node of the spine."""
    bent, pair = bridge.bents[number], bent_directions(bridge, number)
    column, is_pinned = pair[0].column, pair[0].base == "pinned"
    x, _, centroid_m = frame.places[centre]
    frame.add_weight(centre, bent.cap_weight_kn * KN)
    # ASSUME as in the model: a cap does not twist, nor bend vertically above three columns
    area, upright = bent.cap_width_m * bent.cap_depth_m, _RIGID if bent.columns > 2 else 1.0
    parts = 1.0, _RIGID, bent.cap_width_m**2 / 12, upright * bent.cap_depth_m**2 / 12
    cap = tuple(bridge.deck.elastic_modulus_gpa * GPA * area * part for part in parts)
    places = [(i - (bent.columns - 1) / 2) * bent.column_spacing_m for i in range(bent.columns)]
    joints = {y: frame.node((x, y, centroid_m)) for y in places if y} | {0.0: centre}
    for ends in pairwise(joints[y] for y in sorted(joints)):
        frame.beam(ends, cap, _X)
    modulus, outline = column.elastic_modulus_gpa * GPA, column.outline
    torsion = column.torsion_ratio * shear_modulus_pa(modulus) * outline.torsion_m4
    bending = [column.cracked_stiffness_ratio * modulus * outline.inertia_m4(i) for i in (0, 1)]
    shaft = modulus * outline.area_m2, torsion, *bending
    # under dead load the hinges are as stiff as at the start of the moment-curvature curve
    hinges = [np.zeros((2, 2)), np.zeros((2, 2))]
    for capacity, cracked, hinge in zip(pair, bending, hinges, strict=True):
        start = capacity.curve.moment_nm[1] / capacity.curve.curvature_per_m[1]
        softer = 0.0 if is_cracked else capacity.hinge_length_m * (1.0 / start - 1.0 / cracked)
        hinge[:] = np.diag([0.0 if is_pinned else softer, softer])
    held = [dof for dof in range(6) if not (is_pinned and dof in (3, 4))]
    for y in places:
        ends = base, joint = frame.node((x, y, -bent.clear_height_m)), joints[y]
        frame.beam(ends, shaft, _X, -centroid_m, hinges, pair[0].axial_n)
        frame.add_weight(joint, column_weight_n(bridge, bent) / 2)
        if bridge.foundation is None:
            frame.fixed += [6 * base + dof for dof in held]
        else:
            springs = np.array(list(bridge.foundation.model_dump().values())) * MN
            frame.add([base], np.diag(np.where(np.isin(range(6), held), springs, 0.0)))


@dataclass
class _Frame:
    """Nodes with six degrees of freedom, their masses, and stiffness matrices between them."""

    places: list[Place] = field(default_factory=list[Place])
    parts: list[tuple[Any, FloatArray]] = field(default_factory=list[tuple[Any, FloatArray]])
    masses: dict[int, FloatArray] = field(default_factory=dict[int, FloatArray])
    fixed: list[int] = field(default_factory=list[int])

    def node(self, place: Place) -> int:
        self.places.append(place)
        return len(self.places) - 1

    def add_weight(self, node: int, weight_n: float, turning: Place = (0.0, 0.0, 0.0)) -> None:
        values = np.array([weight_n, weight_n, weight_n, *turning]) / G_MPS2
        self.masses[node] = self.masses.get(node, np.zeros(6)) + values

    def add(self, nodes: list[int], stiffness: FloatArray) -> None:
        dofs = np.concatenate([np.arange(6) + 6 * node for node in nodes])
        self.parts.append((dofs, stiffness))

    def beam(
        self,
        ends: tuple[int, int],
        stiffness: tuple[float, ...],
        second: FloatArray,
        end_below_m: float = 0.0,
        hinges: Sequence[FloatArray | float] = (0.0, 0.0),
        axial_n: float = 0.0,
    ) -> None:
        """Add a beam with EA, GJ and EI along the axis ``second`` and across it.

        It ends ``end_below_m`` above its last node. ``hinges`` are added to its flexibility, and
        the axial force makes it softer.
        """
        offset = (0.0, 0.0, end_below_m)
        chord = np.array(self.places[ends[1]]) + offset - self.places[ends[0]]
        length = float(np.linalg.norm(chord))
        third = np.cross(first := chord / length, second)
        moved, turned = np.zeros((3, 12)), np.zeros((2, 3, 12))
        moved[:, :3], moved[:, 6:9], moved[:, 9:] = -np.eye(3), np.eye(3), _turned(offset)
        turned[0, :, 3:6] = turned[1, :, 9:] = np.eye(3)
        axial, torsion, *bending = stiffness
        twist, stretch = first @ (turned[1] - turned[0]), first @ moved
        total = (axial * np.outer(stretch, stretch) + torsion * np.outer(twist, twist)) / length
        axes = (second, third), (third, -second)
        for value, hinge, along, axis in zip(bending, hinges, *axes, strict=True):
            sway = along @ moved / length
            rotations = axis @ turned - sway
            flexibility = length / value / 6 * np.array([[2.0, -1.0], [-1.0, 2.0]]) + hinge
            total += rotations.T @ np.linalg.solve(flexibility, rotations)
            total -= axial_n * length * np.outer(sway, sway)
        self.add(list(ends), total)

    def periods_s(self) -> dict[str, float]:
        size = 6 * len(self.places)
        stiffness, mass = np.zeros((size, size)), np.zeros(size)
        for dofs, part in self.parts:
            stiffness[np.ix_(dofs, dofs)] += part
        for node, values in self.masses.items():
            mass[6 * node : 6 * node + 6] = values
        free = np.setdiff1d(np.arange(size), self.fixed)
        flexibility = np.linalg.inv(stiffness[np.ix_(free, free)])
        heavy = mass[free] > 0.0
        root, direction = np.sqrt(mass[free][heavy]), free[heavy] % 6
        squares, modes = np.linalg.eigh(root[:, None] * flexibility[np.ix_(heavy, heavy)] * root)
        shares = {axis: (modes.T @ (root * (direction == i))) ** 2 for i, axis in enumerate("xyz")}
        return {axis: 2 * pi * sqrt(squares[int(of.argmax())]) for axis, of in shares.items()}


def _turned(arm: Place) -> FloatArray:
    """Return the displacement of the end of a rigid arm for unit rotations."""
    x, y, z = arm
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
