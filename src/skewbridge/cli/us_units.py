"""Tables in kip, inch and foot: converted where they are printed, and nowhere else."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, Literal

import typer

from skewbridge.units import FOOT, INCH, KIP, KJ, KN, MM

type Units = Literal["si", "us"]
UnitsOption = Annotated[
    Units,
    typer.Option("--units", help="Of what is printed: SI, or kip, in, ft. Files and JSON are SI."),
]

_KNM: Final = KN / (KIP * FOOT)
#: Ending of a name -> ending in US units, factor; the longer endings first.
_ENDINGS: Final = {
    "_kn_per_m": ("_kip_per_in", KN / KIP * INCH),
    "_per_m": ("_per_in", INCH),
    "length_m": ("length_ft", 1.0 / FOOT),
    "_mps2": ("_in_per_s2", 1.0 / INCH),
    "_mps": ("_in_per_s", 1.0 / INCH),
    "_knm": ("_kip_ft", _KNM),
    "_kj": ("_kip_ft", KJ / (KIP * FOOT)),
    "_kn": ("_kip", KN / KIP),
    "_mm": ("_in", MM / INCH),
    "_m": ("_in", 1.0 / INCH),
    " (m)": (" (in)", 1.0 / INCH),
}


def in_units(rows: Sequence[Mapping[str, Any]], units: Units) -> list[dict[str, Any]]:
    """Return the rows of a table with heads and numbers in these units.

    A number has the unit that its head ends with, or the name of its quantity or check where the
    rows are quantities or checks.
    """
    if units == "si":
        return [dict(row) for row in rows]
    return [_row_in_us_units(row) for row in rows]


def _row_in_us_units(row: Mapping[str, Any]) -> dict[str, Any]:
    named = next((key for key in ("quantity", "check", "of a column") if key in row), None)
    if named is not None:
        name, factor = _converted(str(row[named]))
        kept = ("ratio", "ok")  # of checks
        return {
            key: name if key == named else value if key in kept else _times(value, factor)
            for key, value in row.items()
        }
    found: dict[str, Any] = {}
    for key, value in row.items():
        name, factor = _converted(key)
        found[name] = _times(value, factor)
    return found


def _converted(name: str) -> tuple[str, float]:
    for ending, (instead, factor) in _ENDINGS.items():
        if name.endswith(ending):
            return name.removesuffix(ending) + instead, factor
    return name, 1.0


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(item, factor) for item in value]
    if factor == 1.0 or isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return value * factor
