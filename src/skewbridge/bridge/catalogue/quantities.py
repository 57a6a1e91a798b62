"""Ranges of the numbers in a bridge file, by quantity and unit."""

from typing import Annotated

from pydantic import BaseModel, Field

# These limits are wider than any real bridge. They detect wrong units, and numbers so large that
# their powers would overflow in the solver.
type Metres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Distance = Annotated[float, Field(ge=0.0, le=1.0e3)]
type Span = Annotated[float, Field(ge=1.0, le=500.0)]
type SquareMetres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Inertia = Annotated[float, Field(ge=1.0e-6, le=1.0e6)]
type Millimetres = Annotated[float, Field(ge=0.1, le=1.0e4)]
type SquareMillimetres = Annotated[float, Field(ge=1.0, le=1.0e5)]
type Gigapascals = Annotated[float, Field(ge=0.1, le=1.0e3)]
type Megapascals = Annotated[float, Field(ge=1.0, le=2.0e3)]
type Kilonewtons = Annotated[float, Field(ge=1.0e-3, le=1.0e7)]
type Weight = Annotated[float, Field(ge=0.0, le=1.0e6)]
type LineLoad = Annotated[float, Field(ge=0.1, le=1.0e5)]
type UnitWeight = Annotated[float, Field(ge=1.0, le=100.0)]
type Tonnes = Annotated[float, Field(ge=1.0e-3, le=1.0e4)]
type Stiffness = Annotated[float, Field(ge=1.0e-3, le=1.0e9)]
type Seconds = Annotated[float, Field(ge=1.0e-2, le=60.0)]
type Factor = Annotated[float, Field(ge=1.0e-3, le=1.0e2)]
type Ratio = Annotated[float, Field(ge=1.0e-4, le=1.0)]


class Part(BaseModel, frozen=True, extra="forbid"):
    """Frozen model that rejects unknown keys."""
