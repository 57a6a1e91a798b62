"""Unit factors: all values inside the package are SI (N, m, s, kg, rad).

Multiply by the factor on input and divide by it on output: ``gap_m = gap_mm * MM``. The axes and
signs are defined in docs/assumptions.md.
"""

import re
from math import isclose
from typing import Final, Literal

#: Unit system of the output.
Units = Literal["si", "us"]

G_MPS2: Final = 9.80665  # source: standard gravity, CGPM 1901

MM: Final = 1.0e-3
KN: Final = 1.0e3
MN: Final = 1.0e6
KJ: Final = 1.0e3
MPA: Final = 1.0e6
GPA: Final = 1.0e9
TONNE: Final = 1.0e3
GAL: Final = 1.0e-2  # cm/s2

# source: exact definitions of the inch (1959) and of the pound-force
INCH: Final = 0.0254
FOOT: Final = 12 * INCH
KIP: Final = 4448.2216152605
PSI: Final = KIP / 1000 / INCH**2
KSI: Final = 1000 * PSI

#: Units by the endings of names, longer endings first.
_NAME_ENDINGS: Final = {
    "_n_per_m": "N/m",
    "_mps": "m/s",
    "_deg": "deg",
    "_mm": "mm",
    "_kn": "kN",
    "_n": "N",
    "_m": "m",
}


def split_unit(name: str) -> tuple[str, str]:
    """Split a name such as ``gap_mm`` into ``gap`` and its unit ``mm`` (``-`` if it has none)."""
    ending = next((ending for ending in _NAME_ENDINGS if name.endswith(ending)), "")
    return name.removesuffix(ending), _NAME_ENDINGS.get(ending, "-")


# --- US units for people

#: US unit of an SI unit and the factor to it; units that end like another one are before it.
_US_UNITS: Final = {
    "MN/m": ("kip/in", MN / KIP * INCH),
    "kN/m": ("kip/in", KN / KIP * INCH),
    "1/m": ("1/in", INCH),
    "m/s2": ("in/s2", 1.0 / INCH),
    "m/s": ("in/s", 1.0 / INCH),
    "MNm": ("kip ft", MN / (KIP * FOOT)),
    "kNm": ("kip ft", KN / (KIP * FOOT)),
    "kJ": ("kip ft", KJ / (KIP * FOOT)),
    "MN": ("kip", MN / KIP),
    "kN": ("kip", KN / KIP),
    "mm": ("in", MM / INCH),
    "m": ("in", 1.0 / INCH),
}
#: Names of lengths in feet: of a bridge, its spans and columns. All others are in inches.
_IN_FEET: Final = re.compile(r"(?:^| )(?:length|spans?|(?:\w+_)?heights?)$")


def us_unit(unit: str, name: str = "") -> tuple[str, float]:
    """Return the US unit for people of an SI unit (else the unit itself), and the factor to it.

    ``name`` is that of the quantity, without its unit: ``length`` and ``clear_height`` are in feet.
    """
    if unit == "m" and _IN_FEET.search(name):
        return "ft", 1.0 / FOOT
    return _US_UNITS.get(unit, (unit, 1.0))


def us_name(name: str) -> tuple[str, float]:
    """Return a name with the US unit of its ending (``_kn``, `` (kN)``), and the factor to it."""
    value = re.sub("_(low|high)$", "", name)  # ends of an interval have the unit of the value
    for unit in _US_UNITS:
        for written in (_ending, " ({})".format):
            if value.endswith(written(unit)):
                stem = value.removesuffix(written(unit))
                us, factor = us_unit(unit, stem)
                return stem + written(us) + name.removeprefix(value), factor
    return name, 1.0


def _ending(unit: str) -> str:
    """Return the ending of a name with this unit: ``_mps2``, ``_kip_per_in``."""
    words = unit.lower().replace("m/s", "mps").replace("1/", "per_").replace("/", "_per_")
    return "_" + words.replace(" ", "_")


# --- quantities as text, such as "5 ksi"

# a prime for each of force, length and time: the product of their powers identifies a dimension
_N, _M, _S = 2.0, 3.0, 5.0
_FACTORS: Final = {
    _M: {"m": 1.0, "mm": MM, "cm": 10 * MM, "ft": FOOT, "in": INCH},
    _N: {"n": 1.0, "kn": KN, "mn": MN, "kip": KIP, "kips": KIP, "lb": KIP / 1000},
    _N / _M: {"plf": KIP / 1000 / FOOT, "klf": KIP / FOOT},
    _N / _M**2: {"pa": 1.0, "kpa": KN, "mpa": MPA, "gpa": GPA, "psi": PSI, "ksi": KSI,
                 "psf": PSI / 144, "ksf": KSI / 144},
    _N / _M**3: {"pcf": KIP / 1000 / FOOT**3},
    _N * _M: {"mnm": MN},
    _N / _M * _S**2: {"t": TONNE, "kg": 1.0, "lbm": KIP / 1000 / G_MPS2},
    _S: {"s": 1.0},
    1.0: {"rad": 1.0},
}  # fmt: skip
_UNITS: Final = {
    name: (factor, kind) for kind, units in _FACTORS.items() for name, factor in units.items()
}
_NUMBER: Final = re.compile(r"(\d{1,15}+(?:\.\d{0,15})?+(?:e[-+]?\d{1,3})?+)\s*(\S.{0,30})", re.I)
_FEET_AND_INCHES: Final = re.compile(
    r"(?:(\d{1,6}(?:\.\d{1,9})?)(?:'| ?ft)[ -]*)?"
    r"(?:(\d{1,6}(?:\.\d{1,9})?)?(?:(?:(?<=\d)[ -]|(?<!\d))(\d{1,3})/([1-9]\d{0,2}))?(?:\"| ?in))?"
)
_NAME_UNIT: Final = re.compile(r"_((?:mnm|[mk]?n|mm|m|[mgk]?pa|t|s)\d?(?:_per_(?:m|rad)\d?)?)$")


def unit_in_name(name: str) -> str | None:
    """Return the unit in a name: ``kn/m3`` for ``weight_kn_per_m3``, None if it has none."""
    match = _NAME_UNIT.search(name)
    return match[1].replace("_per_", "/") if match else None


def quantity(text: str, unit: str) -> float:
    """Return the number of ``unit`` in a text such as ``150 ft``, ``5'-6"`` or ``50 kip/in``.

    `ValueError` if the text is not a number and a unit, or its unit is of another dimension.
    """
    unit_factor, unit_dimension = _factor(unit)
    if "," in text:
        raise ValueError("must have a decimal point, and no commas")
    match = _FEET_AND_INCHES.fullmatch(text.strip())
    if match and any(match.groups()):
        feet, inches, numerator, denominator = (float(number or 0.0) for number in match.groups())
        value_si, dimension = feet * FOOT + (inches + numerator / (denominator or 1.0)) * INCH, _M
    elif number_match := _NUMBER.fullmatch(text.strip()):
        factor, dimension = _factor(number_match[2])
        value_si = float(number_match[1]) * factor
    else:
        number = "a valid number without quotes (exponents as in 2.0e+7)"
        raise ValueError(f"must be {number}, or with a unit such as {unit}")
    if not isclose(dimension, unit_dimension):
        raise ValueError(f"has a unit of another quantity: it must be a unit such as {unit}")
    return float(f"{value_si / unit_factor:.12g}")


def _factor(unit: str) -> tuple[float, float]:
    """Return factor to SI and dimension (product of primes) of a unit such as ``kip/in/ft``."""
    total_factor, dimension = 1.0, 1.0
    for slashes, group in enumerate(unit.lower().split("/")):
        for name in re.split(r"[-* ]+", group.strip()):
            match = re.fullmatch(r"([a-z]+)\^?([1-4]?)", name)
            if match is None or match[1] not in _UNITS:
                raise ValueError("must be a valid number, or have a known unit such as ft or ksi")
            power = int(match[2] or 1) * (-1 if slashes else 1)
            total_factor *= _UNITS[match[1]][0] ** power
            dimension *= _UNITS[match[1]][1] ** power
    return total_factor, dimension
