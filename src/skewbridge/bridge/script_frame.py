"""Classes that the script of a user's bridge returns; lengths and forces are in its units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Column:
    """One column; without a capacity, the limit states that need it are absent.

    Attributes:
        element: Beam-column element at the base, of any kind.
        base: Node at the base.
        top: Node at the top of the column, or in the deck above it.
        height: Clear height; by default up to ``top``.
        drift_capacity: Displacement capacity over clear height, or a pair of them along x and y.
        shear_strength: Shear strength, or a function of the axial force (compression positive) and
            the ductilities of drift and curvature, as arrays.
        yield_drift: Yield displacement over clear height, for the ductility of drift.
        yield_curvature: Yield curvature, for the ductility of curvature.
        hinges: Integration points (from 1) at which the curvature is read.
    """

    element: int
    base: int
    top: int
    height: float | None = None
    drift_capacity: float | Sequence[float] | None = None
    shear_strength: float | Callable[..., Any] | None = None
    yield_drift: float | None = None
    yield_curvature: float | None = None
    hinges: Sequence[int] = ()


@dataclass(frozen=True, slots=True)
class End:
    """One end of the deck; values that are None are derived, or taken from the `Frame`.

    Attributes:
        node: End node of the deck; the script does not support it.
        width: Width of the deck.
        soffit: Distance from the node down to the soffit, where pads, walls and keys are.
        outward: Direction of the deck out of its end in plan; by default that of its last element.
        abutment: As in `Frame`.
    """

    node: int
    width: float | None = None
    soffit: float | None = None
    outward: tuple[float, float] | None = None
    abutment: "str | Mapping[str, Any] | None" = None


@dataclass(frozen=True, slots=True)
class Frame:
    """The bridge that a script has built, without its abutments and before its dead load.

    Attributes:
        ends: End nodes of the deck, or an `End` for each of them.
        width: Width of the deck.
        soffit: Distance from the end nodes down to the soffit.
        columns: All columns.
        units: Units of the script, such as ``kip-in``; the unit of time is the second.
        abutment: Name of a bridge of the catalogue, or keys of the section ``abutment`` of a
            bridge file; by default osb1's. Sizes and strengths are those of the named bridge
            times the ratio of the deck widths, keys count as given.
        loads: Dead load (downward) by node. By default the nodal loads of the script, or the
            vertical nodal masses times g.
        damping_ratio: Rayleigh damping of ``damped`` at ``damping_periods``.
        damping_periods: Long and short period in s. By default those of the modes with most mass
            along or across the bridge and vertically, at zero skew.
        damped: Damped elements; by default all beam-columns.
        centre: Node whose displacement is that of the deck; by default the node of the deck
            nearest to the mass centre.
        t1: Conditioning period in s; by default from the modes at zero skew.
        title: Title for pages.
    """

    ends: Sequence[int | End]
    width: float
    soffit: float
    columns: Sequence[Column] = ()
    units: str = "N-m"
    abutment: str | Mapping[str, Any] | None = None
    loads: Mapping[int, float] | None = None
    damping_ratio: float = 0.05
    damping_periods: tuple[float, float] | None = None
    damped: Sequence[int] | None = None
    centre: int | None = None
    t1: float | None = None
    title: str = ""
