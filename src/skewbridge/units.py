"""Unit factors: all values inside the package are SI (N, m, s, kg, rad).

Multiply by the factor on input and divide by it on output: ``gap_m = gap_mm * MM``. The axes and
signs are defined in docs/assumptions.md.
"""

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
_IN_NAMES: Final = {
    "_n_per_m": "N/m",
    "_deg": "deg",
    "_mm": "mm",
    "_kn": "kN",
    "_n": "N",
    "_m": "m",
}


def split_unit(name: str) -> tuple[str, str]:
    """Return a name without its unit ending, and the unit (``-`` if the name has none)."""
    ending = next((ending for ending in _IN_NAMES if name.endswith(ending)), "")
    return name.removesuffix(ending), _IN_NAMES.get(ending, "-")
