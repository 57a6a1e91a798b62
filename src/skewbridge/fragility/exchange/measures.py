"""Names of intensity measures in other tools."""

import re
from collections.abc import Mapping
from typing import Final

from skewbridge.errors import InputError

_CMPS_PER_MPS: Final = 100.0  # OpenQuake takes PGV in cm/s


def openquake_measure(column: str) -> tuple[str, float]:
    """Return the OpenQuake name of an intensity column and the factor to its unit.

    Raises:
        InputError: OpenQuake has no such measure.
    """
    named = {"im_pga": ("PGA", 1.0), "im_pgv": ("PGV", _CMPS_PER_MPS), "im_saavg": ("AvgSA", 1.0)}
    advice = "name in OpenQuake: fit with im_sa_1p000_rotd50_g or another Sa(T)"
    return _named(column, ("SA({period_s})", 1.0), named, advice)


def pelicun_demand(column: str) -> tuple[str, str]:
    """Return the demand type of an intensity column and its unit in pelicun.

    Raises:
        InputError: pelicun has no such demand.
    """
    named = {
        "im_pga": ("Peak Ground Acceleration", "g"),
        "im_pgv": ("Peak Ground Velocity", "mps"),
        "im_saavg": ("Spectral Acceleration|Avg", "g"),
        "im_sa_t1": ("Spectral Acceleration|T1", "g"),
    }
    spectral = ("Spectral Acceleration|{period_s}", "g")
    return _named(column, spectral, named, "demand type in pelicun")


def _named[Unit](
    column: str, spectral: tuple[str, Unit], named: Mapping[str, tuple[str, Unit]], what: str
) -> tuple[str, Unit]:
    """Return name and unit of an intensity column: a spectral acceleration, else by its start."""
    match = re.match(r"im_sa_(\d+)p(\d+)_", column)
    if match:
        return spectral[0].format(period_s=f"{float(f'{match[1]}.{match[2]}'):g}"), spectral[1]
    for start, found in named.items():
        if column.startswith(start):
            return found
    raise InputError(f"{column} has no {what}", column=column)
