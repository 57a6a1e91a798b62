"""Unit systems of scripts, and an SI view of a domain in other units.

The domain of a script has the units of the script. While the view is in force, every OpenSees
command of this package takes and returns SI values: `_ARGUMENTS` and `_ANSWERS` state what each
number is, and the view multiplies it. The commands of the script itself are not touched.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.handles import TagAllocator
from skewbridge.errors import InputError
from skewbridge.units import FOOT, INCH, KIP, KN, MM

#: Powers of force and length in a quantity; the unit of time is the second.
type Dimension = tuple[float, float]

DIMENSIONLESS: Final[Dimension] = (0, 0)
FORCE: Final[Dimension] = (1, 0)
LENGTH: Final[Dimension] = (0, 1)
MOMENT: Final[Dimension] = (1, 1)
STIFFNESS: Final[Dimension] = (1, -1)  # also mass and dashpot coefficient
PER_LENGTH: Final[Dimension] = (0, -1)
_MODULUS: Final[Dimension] = (1, -2)
_PLACE: Final = (LENGTH,) * 3
_MOVED: Final = (*_PLACE, *(DIMENSIONLESS,) * 3)  # also velocity and acceleration
_FORCES: Final = (*(FORCE,) * 3, *(MOMENT,) * 3)
_BEAM: Final = ((0, 2), _MODULUS, _MODULUS, *((0, 4),) * 3)

_FORCE_UNITS: Final = {"N": 1.0, "kN": KN, "MN": 1e6, "kip": KIP, "lb": KIP / 1e3}
_LENGTH_UNITS: Final = {"m": 1.0, "mm": MM, "cm": 1e-2, "in": INCH, "ft": FOOT}


@dataclass(frozen=True, slots=True)
class UnitSystem:
    """Unit of force in N and unit of length in m of a domain."""

    force_n: float = 1.0
    length_m: float = 1.0

    @classmethod
    def named(cls, name: str) -> "UnitSystem":
        """Return a unit system such as ``kip-in``; `InputError` for an unknown one."""
        force, _, length = f"{name}".partition("-")
        if force not in _FORCE_UNITS or length not in _LENGTH_UNITS:
            raise InputError(
                f"units must be FORCE-LENGTH with a force of {', '.join(_FORCE_UNITS)} and a "
                f"length of {', '.join(_LENGTH_UNITS)}, such as kip-in, got {name!r}"
            )
        return cls(_FORCE_UNITS[force], _LENGTH_UNITS[length])

    def si(self, dimension: Dimension) -> float:
        """Return the factor that converts a quantity of this dimension to SI."""
        force, length = dimension
        return self.force_n**force * self.length_m**length

    def record_factors(self, response: Sequence[str], width: int) -> np.ndarray:
        """Return the factors to SI of the components of a recorded response, shape (width,)."""
        dimensions: dict[str, Sequence[Dimension]] = {
            "disp": _MOVED,
            "accel": _MOVED,
            "basicForce": (FORCE,),
            "deformation": (DIMENSIONLESS, PER_LENGTH, PER_LENGTH, PER_LENGTH),
        }
        pattern = dimensions.get(response[-1], _FORCES)
        return np.array([self.si(pattern[index % len(pattern)]) for index in range(width)])


# source: default of the material, in any units; its stiffness at rest depends on it
_LEAST_SPEED_MPS: Final = 1.0e-11
#: Numbers of a material after its tag; the last dimension repeats. Texts are kept.
_MATERIALS: Final[Mapping[str, Sequence[Dimension]]] = {
    "ENT": (STIFFNESS,),
    "Elastic": (STIFFNESS,),
    "ElasticPP": (STIFFNESS, LENGTH),
    "ElasticPPGap": (STIFFNESS, FORCE, LENGTH, DIMENSIONLESS),
    "Hysteretic": (FORCE, LENGTH) * 6 + (DIMENSIONLESS,),
    "Steel01": (FORCE, STIFFNESS, DIMENSIONLESS),
    "InitStrainMaterial": (DIMENSIONLESS, LENGTH),
    "ASDConcrete1D": (STIFFNESS,),
}
_CURVES: Final = {"-Ce": LENGTH, "-Te": LENGTH, "-Cs": FORCE, "-Ts": FORCE}
_PARAMETERS: Final = {"E": STIFFNESS, "eta": STIFFNESS, "Fy": FORCE, "epsInit": LENGTH}
type Numbers = tuple[int, Iterable[Dimension]]
_NO_NUMBERS: Final[Numbers] = (0, ())
_BIDIRECTIONAL: Final = (DIMENSIONLESS, STIFFNESS, FORCE, STIFFNESS, STIFFNESS)
_TOLERANCES: Final = {"NormDispIncr": LENGTH, "EnergyIncr": MOMENT}
#: Numbers of other commands by their arguments: the position of the first, and their dimensions.
_ARGUMENTS: Final[Mapping[str, Callable[[Sequence[Any]], Numbers]]] = {
    "node": lambda _: (1, _PLACE),
    "mass": lambda _: (1, (*(STIFFNESS,) * 3, *(MOMENT,) * 3)),
    "load": lambda _: (1, _FORCES),
    "constraints": lambda _: (1, (STIFFNESS, STIFFNESS)),
    "section": lambda v: (1, _BIDIRECTIONAL) if v[0] == "Bidirectional" else _NO_NUMBERS,
    "timeSeries": lambda v: (
        (v.index("-values") + 1, repeat(LENGTH)) if v[0] == "Path" else _NO_NUMBERS
    ),
    "test": lambda v: (1, (_TOLERANCES[v[0]],)),
    "sp": lambda v: (2, (_MOVED[int(v[1]) - 1],)),
    "integrator": lambda v: (
        (3, (_MOVED[int(v[2]) - 1],)) if v[0] == "DisplacementControl" else _NO_NUMBERS
    ),
}
_ANSWERS: Final[Mapping[str, Sequence[Dimension]]] = {
    "nodeCoord": _PLACE,
    "nodeDisp": _MOVED,
    "nodeVel": _MOVED,
    "nodeMass": (*(STIFFNESS,) * 3, *(MOMENT,) * 3),
    "nodeReaction": _FORCES,
    "eleForce": (*_FORCES, *_FORCES),
    "basicForce": (FORCE,) * 8,
    "basicDeformation": (LENGTH,) * 8,
    "basicStiffness": (STIFFNESS,) * 64,  # of the contacts: springs only
}
_replaced: list[tuple[Any, str, Callable[..., Any]]] = []


def end_view() -> None:
    """End the SI view of the domain, if there is one."""
    while _replaced:
        setattr(*_replaced.pop())


def _replace(name: str, command: Callable[..., Any]) -> None:
    """Replace a command of OpenSees until `end_view`."""
    _replaced.append((ops, name, getattr(ops, name)))
    setattr(ops, name, command)


def view_constraints() -> None:
    """Make `ops.constraints` handle rigid links: by transformation, unless by penalties."""
    _replace("constraints", partial(_transformed, ops.constraints))


def _transformed(command: Callable[..., Any], handler: str, *penalties: float) -> None:
    command(*(handler, *penalties) if handler == "Penalty" else ("Transformation",))


class SiView:
    """SI view of the open domain of a script in other units, until `end_view`."""

    def __init__(self, units: UnitSystem, tags: TagAllocator) -> None:
        self._units, self._tags = units, tags
        self._parameters: dict[int, Dimension] = {}
        self._rotational: dict[int, tuple[float, ...]] = {}
        for name, numbers in _ARGUMENTS.items():
            _replace(name, partial(self._call, getattr(ops, name), numbers))
        for name, dimensions in _ANSWERS.items():
            _replace(name, partial(self._answer, getattr(ops, name), dimensions))
        commands: dict[str, Callable[..., Any]] = {
            "uniaxialMaterial": self._material,
            "element": self._element,
            "parameter": self._parameter,
            "updateParameter": self._update,
            "getParamValue": self._value,
            "eleResponse": self._response,
        }
        for name, converted in commands.items():
            _replace(name, partial(converted, getattr(ops, name)))

    def _taken(self, values: Iterable[Any], dimensions: Iterable[Dimension]) -> Iterator[Any]:
        """Convert SI values to the units of the script; texts and tags (integers) are kept."""
        for value, dimension in zip(values, dimensions, strict=False):
            yield value / self._units.si(dimension) if isinstance(value, float) else value

    def _call(
        self, command: Callable[..., Any], numbers: Callable[[Sequence[Any]], Numbers], *values: Any
    ) -> Any:
        first, dimensions = numbers(values)
        converted = list(self._taken(values[first:], dimensions))
        return command(*values[:first], *converted, *values[first + len(converted) :])

    def _answer(
        self, command: Callable[..., Any], dimensions: Sequence[Dimension], *values: Any
    ) -> Any:
        answer = command(*values)
        if not isinstance(answer, list):  # one component, named by the last argument
            return answer * self._units.si(dimensions[values[-1] - 1])
        return [v * self._units.si(d) for v, d in zip(answer, dimensions, strict=False)]

    def _material(self, command: Callable[..., Any], kind: str, tag: int, *values: Any) -> None:
        if kind == "Viscous":
            values = *values, _LEAST_SPEED_MPS
            dimensions: Iterable[Dimension] = ((1, -float(values[1])), DIMENSIONLESS, LENGTH)
        elif kind == "ASDConcrete1D":
            dimensions = self._curves(values)
        else:
            known_dimensions = _MATERIALS[kind]
            dimensions = chain(known_dimensions, repeat(known_dimensions[-1]))
        if kind == "Elastic":
            self._rotational[tag] = values
        command(kind, tag, *self._taken(values, dimensions))

    @staticmethod
    def _curves(values: Sequence[Any]) -> Iterator[Dimension]:
        dimension = STIFFNESS
        for value in values:
            dimension = _CURVES.get(value, DIMENSIONLESS) if isinstance(value, str) else dimension
            yield dimension

    def _element(self, command: Callable[..., Any], kind: str, *values: Any) -> None:
        tag, arguments = values[:3], values[3:]
        if kind == "elasticBeamColumn":
            arguments = *self._taken(arguments, _BEAM), *arguments[len(_BEAM) :]
        elif kind == "elastomericBearingPlasticity":
            # its springs in bending and twist need stiffnesses of their own, in force x length
            bearing = [*self._taken(arguments[:2], (STIFFNESS, FORCE)), *arguments[2:]]
            for index, value in enumerate(bearing):
                if value in ("-T", "-My", "-Mz"):
                    spring, new_tag = self._rotational[bearing[index + 1]], self._tags.material()
                    converted = self._taken(spring, repeat(MOMENT))
                    self._raw("uniaxialMaterial")("Elastic", new_tag, *converted)
                    bearing[index + 1] = new_tag
            arguments = tuple(bearing)
        elif kind not in ("zeroLength", "zeroLengthSection"):
            raise NotImplementedError(f"no conversion of units for {kind}: write the script in N-m")
        command(kind, *tag, *arguments)

    @staticmethod
    def _raw(name: str) -> Callable[..., Any]:
        """Return the OpenSees command that uses the units of the script."""
        return next(command for module, attr, command in _replaced if (module, attr) == (ops, name))

    def _parameter(self, command: Callable[..., Any], tag: int, *values: Any) -> None:
        self._parameters[tag] = _PARAMETERS[values[-1]]
        command(tag, *values)

    def _update(self, command: Callable[..., Any], tag: int, value: float) -> None:
        command(tag, value / self._units.si(self._parameters[tag]))

    def _value(self, command: Callable[..., Any], tag: int) -> float:
        return command(tag) * self._units.si(self._parameters[tag])

    def _response(self, command: Callable[..., Any], tag: int, *response: str) -> list[float]:
        answer = np.array(command(tag, *response), dtype=np.float64)
        if response[-1] == "basicStiffness":  # of a beam: axial, four rotations, twist
            scale = np.array([self._units.length_m, *[1.0] * 5])
            return (answer * self._units.si(MOMENT) / np.outer(scale, scale).ravel()).tolist()
        if not response[-1].endswith("axis"):
            answer = answer * self._units.record_factors(response, len(answer))
        return answer.tolist()
