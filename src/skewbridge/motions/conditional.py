"""Conditional spectra, to which records are selected.

ln PSA has the mean and standard deviation of Boore et al. (2014) and the correlation of Baker and
Jayaram (2008), see `synthesis.bssa14`. It is conditioned on its mean at the period of SA(T) (Baker
2011, J. Struct. Eng. 137(3)) or the 20 periods of Sa_avg(T1) (Kohrangi et al. 2017, EESD 46(10)).
Earthquakes are mixed by their contributions (Lin et al. 2013, BSSA 103(2A)).
"""

import io
import re
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal, NamedTuple

import numpy as np
import pandas as pd
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass
from scipy.interpolate import PchipInterpolator
from scipy.stats import norm

from skewbridge.errors import InputError
from skewbridge.files import text
from skewbridge.files.text import Number
from skewbridge.motions.levels import Level
from skewbridge.motions.record import Vector
from skewbridge.motions.spectrum import SPECTRUM_PERIODS_S, sa_avg_periods
from skewbridge.motions.synthesis.bssa14 import baker_jayaram_correlation, bssa14
from skewbridge.motions.synthesis.ddk18 import Scenario

BAND_POINTS: Final = 39  # every second one is a period of Sa_avg(T1)
_ROW: Final = ("magnitude", "distance_km", "epsilon", "weight", "level_g")


class Rupture(Scenario):
    """Earthquake and site within the range of BSSA14, which exceeds that of the generator."""

    LIMITS: ClassVar = {
        "magnitude": (3.0, 8.5), "distance_km": (0.0, 400.0), "vs30_mps": (150.0, 1500.0)
    }  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, config=text.OPTIONS)
class Cause:
    """One of the earthquakes that cause a level."""

    magnitude: Number
    distance_km: Number
    epsilon: Annotated[Number, Field(ge=-6.0, le=6.0)]  # at the level: epsilon-0 of the USGS
    weight: Annotated[Number, Field(gt=0.0)] = 1.0
    level_g: Level | None = None  # None: of BSSA14 at this epsilon


def _listed(level: Any) -> Any:
    return level if isinstance(level, list) else [level]


_Causes = Annotated[tuple[Cause, ...], Field(min_length=1), BeforeValidator(_listed)]


@dataclass(frozen=True, slots=True, kw_only=True, config=text.OPTIONS)
class Target:
    """Intensity measure, site, period of the bridge (None: of the measure), earthquakes."""

    measure: Annotated[str, Field(pattern=r"^(SA|Sa_avg3?)\((\d*\.)?\d+\)$")]
    vs30_mps: Number
    mechanism: Literal["strike_slip", "reverse"] = "strike_slip"
    t1_s: Number | None = None
    levels: Annotated[tuple[_Causes, ...], Field(min_length=1, max_length=20)]


class ConditionalSpectrum(NamedTuple):
    """PSA at `BAND_POINTS` periods from 0.2 to 3 T1, then at the periods of the measure."""

    periods_s: Vector
    median_g: Vector
    sigma: Vector  # standard deviation of ln PSA
    weights: Vector  # their product with ln PSA is the logarithm of the measure
    causes: dict[str, float]  # level, means of the earthquakes, level of BSSA14 at this epsilon


def condition(
    mean: Vector, covariance: Vector, weights: Vector, epsilon: float
) -> tuple[Vector, Vector]:
    """Return mean and covariance if the weighted sum is epsilon deviations above its mean."""
    gain = covariance @ weights
    slope = gain / np.sqrt(weights @ gain)
    return mean + epsilon * slope, covariance - np.outer(slope, slope)


def conditional_spectra(target: Target) -> list[ConditionalSpectrum]:
    """Return the spectrum of each level; `InputError` for values outside the range of BSSA14."""
    period_s = float(target.measure.split("(")[1][:-1])
    own = sa_avg_periods(period_s) if "avg" in target.measure else np.array([period_s])
    band = (target.t1_s or period_s) * np.geomspace(0.2, 3.0, BAND_POINTS)
    periods = np.append(band, own)
    if not 0.01 <= periods.min() <= periods.max() <= 10.0:
        found = f"{periods.min():.3g} to {periods.max():.3g} s"
        raise InputError(f"0.2 T1 to 3 T1 and the measure must be within 0.01 to 10 s, got {found}")
    weights = np.append(np.zeros(BAND_POINTS), np.full(own.size, 1.0 / own.size))
    rho = baker_jayaram_correlation(periods)
    site: dict[str, Any] = {"vs30_mps": target.vs30_mps, "mechanism": target.mechanism}
    spectra: list[ConditionalSpectrum] = []
    for level in target.levels:
        means, variances = list[Vector](), list[Vector]()
        for cause in level:
            rupture = Rupture(magnitude=cause.magnitude, distance_km=cause.distance_km, **site)
            median_g, sigma = bssa14(rupture, SPECTRUM_PERIODS_S)
            # between tabulated periods within 1 % of the equations, 0.1 to 5 s
            known = np.stack([np.log(median_g), sigma], axis=1)
            mean, sigma = PchipInterpolator(np.log(SPECTRUM_PERIODS_S), known)(np.log(periods)).T
            found = condition(mean, rho * np.outer(sigma, sigma), weights, cause.epsilon)
            means.append(found[0])
            variances.append(found[1].diagonal())
        rows = np.array([(c.weight, c.magnitude, c.distance_km, c.epsilon) for c in level])
        share = rows[:, 0] / rows[:, 0].sum()
        reached = np.array(means) @ weights
        bssa14_g = float(np.exp(share @ reached))
        causes = {"level_g": level[0].level_g or bssa14_g, "bssa14_level_g": bssa14_g}
        causes |= zip(_ROW[:3], (share @ rows[:, 1:]).tolist(), strict=True)
        # ASSUME the models of the hazard differ from BSSA14 by the same factor at all periods
        scaled = np.array(means) + (np.log(causes["level_g"]) - reached)[:, None]
        mean = share @ scaled
        sigma = np.sqrt(np.maximum(share @ variances + share @ (scaled - mean) ** 2, 0.0))
        spectra.append(ConditionalSpectrum(periods, np.exp(mean), sigma, weights, causes))
    return spectra


def read_target(path: Path, measure: str | None = None, **given: Any) -> Target:
    """Return the target in a file: YAML by hand, CSV of OpenQuake, or JSON of the USGS.

    ``measure`` selects from a disaggregation with several; ``given`` values that are not None
    replace those of the file. Raises `InputError` for missing (such as epsilon) or wrong values.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        raw = text.read_mapping(path)
    else:
        table = _openquake(path) if path.suffix.lower() == ".csv" else _usgs(path)
        names = table["measure"].unique().tolist()
        if len(names) != 1 if measure is None else measure not in names:
            raise text.file_fault(path, f" has {', '.join(names) or 'no rates'}: give one measure")
        own = table[table["measure"] == (measure or names[0])]
        groups = own[list(_ROW)].groupby("level_g", sort=False)
        raw = {"measure": measure or names[0], "levels": [g.to_dict("records") for _, g in groups]}
    return text.checked(Target, raw | {k: v for k, v in given.items() if v is not None}, path)


def _openquake(path: Path) -> pd.DataFrame:
    """Return measures and rows of causes in the export Mag_Dist_Eps of OpenQuake 3.16 or later."""
    names = {"imt": "measure", "iml": "level_g", "mag": "magnitude", "dist": "distance_km"}
    content = io.StringIO(text.read_text(path, text.MAX_CSV_BYTES))
    try:
        table = pd.read_csv(content, comment="#").rename(columns=names).astype({"eps": float})
        (column,) = (name for name in table if name == "mean" or str(name).startswith("rlz"))
        rate = -np.log1p(-np.minimum(table[column], 1.0 - 1.0e-12))
        rows = table.assign(weight=rate, moment=rate * table["eps"])[rate > 0.0]
        cells = rows.groupby(list(names.values()), sort=False)
    except (KeyError, ValueError) as error:
        needed = "Mag_Dist_Eps with imt, iml, mag, dist, eps and one column of probabilities"
        raise text.file_fault(path, f" is not the export {needed}: {error}") from None
    totals = cells[["weight", "moment"]].sum().reset_index()
    epsilon = (totals["moment"] / totals["weight"]).to_numpy()
    if cells["eps"].max().eq(rows["eps"].max()).all():
        # of all motions above the level (`epsilon_star: false`): the mean is E[x | x > epsilon]
        grid = np.linspace(-4.0, 6.0, 2001)
        epsilon = np.interp(epsilon, norm.pdf(grid) / norm.sf(grid), grid)
    return totals.assign(epsilon=epsilon)


def _usgs(path: Path) -> pd.DataFrame:
    """Return measures and rows of causes in a disaggregation of the USGS, by epsilon-0."""
    rows: list[tuple[Any, ...]] = []
    try:
        response = text.read_json(path)["response"]
        shared = response["metadata"] if isinstance(response, dict) else {}
        for block in response["disaggs"] if shared else response:
            about = shared | block | block.get("metadata", {})
            imt = about["imt"]["value"] if isinstance(about["imt"], dict) else about["imt"]
            measure = re.sub(r"^SA(\d+)P(\d+)$", r"SA(\1.\2)", imt)
            ends = {own["id"]: [own.get("min"), own.get("max")] for own in about["εbins"]}
            # an open bin has the value of its edge
            epsilon = {
                n: np.mean([end for end in own if end is not None]) for n, own in ends.items()
            }
            total = next(o for o in block["data"] if o.get("component", "Total") == "Total")
            items = [item for part in total["summary"] for item in part["data"]]
            level_g = next(item["value"] for item in items if item.get("units") == "g")
            for cell in total["data"]:
                for own in cell["εdata"]:
                    row = (cell["m"], cell["r"], epsilon[own["εbin"]], own["value"], level_g)
                    rows.append((measure, *row))
    except (KeyError, TypeError, AttributeError, StopIteration) as error:
        problem = " is not a disaggregation of the USGS by magnitude, distance and epsilon"
        raise text.file_fault(path, f"{problem}: {error!r}") from None
    return pd.DataFrame(rows, columns=["measure", *_ROW])
