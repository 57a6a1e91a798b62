"""Values only: one column, or the OpenSees `.acc`/`.g3` layout with any number per line.

The time step is not in such a file and must be given; the unit is g unless given.
"""

from pathlib import Path
from typing import Final

from skewbridge.motions.formats.numbers import parse_numbers
from skewbridge.motions.formats.trace import UNIT_FACTORS, Given, Trace, dt_of, unit_of

NAME: Final = "values"


def recognises(lines: list[str], path: Path) -> bool:
    """Return True: bare values have no mark of their own, so this reader stands last."""
    return True


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read a file of values.

    Raises:
        InputError: Something that is not a number.
        DtMissingError: No time step given.
    """
    values = parse_numbers(lines, path)
    dt_s, _ = dt_of(given, None, path)
    unit, notes = unit_of(given, None)
    return Trace(
        path=path,
        format=NAME,
        accel_mps2=values * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        notes=tuple(notes),
    )
