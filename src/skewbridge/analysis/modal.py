"""Periods and participating masses of a model under dead load, its gaps open."""

from contextlib import nullcontext
from dataclasses import dataclass
from math import inf, pi, sqrt

import openseespy.opensees as ops

from skewbridge.bridge.gravity import column_axial_forces_n, support_reactions_n
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """One mode: period and participating shares of the free mass along x, y, z and in plan."""

    period_s: float  # infinite for a mechanism
    mass_x: float
    mass_y: float
    mass_z: float
    mass_rz: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalResult:
    """Dead-load state and modes of a variant."""

    weight_kn: float
    column_axial_kn: tuple[float, ...]
    abutment_reaction_kn: tuple[float, float]
    modes: tuple[Mode, ...]

    def period_s(self, direction: str) -> float:
        """Return the period of the mode with the most mass along ``x, y, z`` or ``rz``.

        By participation and never by number: modes couple and change places with skew.
        """
        return max(self.modes, key=lambda mode: getattr(mode, f"mass_{direction}")).period_s


def modal_properties(
    variant: Variant, options: ModelOptions | None = None, *, count: int = 14
) -> ModalResult:
    """Build a variant, apply gravity and return its modes.

    Raises:
        InputError: Bad bridge or variant.
        GravityError: The model does not carry its weight.
    """
    with domain():
        model = build(variant, options or ModelOptions())
        left, right = support_reactions_n(model)
        return ModalResult(
            weight_kn=model.weight_n / KN,
            column_axial_kn=tuple(force / KN for force in column_axial_forces_n(model)),
            abutment_reaction_kn=(left / KN, right / KN),
            modes=modes_of(model, count),
        )


def modes_of(model: BridgeModel, count: int) -> tuple[Mode, ...]:
    """Return the modes of a model under dead load, its gaps open.

    Open friction springs count as soft. Walls and keys are held from here on: behind open gaps
    they are not coupled to the bridge, and their local modes would fill the list.
    """
    for end in model.abutments:
        for node in {*end.key_nodes, *(spring.nodes[1] for spring in end.wing_springs)}:
            ops.fix(node, 1, 1, 0, 0, 0, 0)
    soft = nullcontext() if model.contacts is None else model.contacts.soft_tangents()
    with soft:
        squares = [float(value) for value in ops.eigen(count)]
        ratios = ops.modalProperties("-return")
    names = {"mass_x": "MX", "mass_y": "MY", "mass_z": "MZ", "mass_rz": "RMZ"}
    return tuple(
        Mode(
            period_s=2 * pi / sqrt(square) if square > 0.0 else inf,
            **{name: ratios[f"partiMassRatios{told}"][i] / 100 for name, told in names.items()},
        )
        for i, square in enumerate(squares)
    )
