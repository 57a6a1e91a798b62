"""Conditional spectra of a site, and selection of pairs whose spectra follow them.

ln PSA has the mean and standard deviation of Boore et al. (2014) and the correlation of Baker and
Jayaram (2008), see `synthesis`. It is conditioned on its mean at the period of SA(T) (Baker
2011, J. Struct. Eng. 137(3)) or the 20 periods of Sa_avg(T1) (Kohrangi et al. 2017, EESD 46(10)).
Earthquakes are mixed by their contributions (Lin et al. 2013, BSSA 103(2A)).

Each pair is scaled to a level. As in the greedy step of Baker and Lee (2018, J. Earthq. Eng.
22(4)), pairs are replaced one by one while mean and deviation of ln PSA approach the target.
"""

import io
import re
import shutil
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal, NamedTuple, Self

import numpy as np
import pandas as pd
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
from scipy.interpolate import PchipInterpolator
from scipy.stats import norm

from skewbridge.errors import InputError
from skewbridge.files import text
from skewbridge.files.tables import Index, Mask, records_of
from skewbridge.files.text import Number, writable_file, writable_folder
from skewbridge.motions.folder import (
    INDEX_NAME,
    index_row,
    list_motions,
    read_index_table,
    write_index,
)
from skewbridge.motions.intensity import SPECTRUM_PERIODS_S, pair_psa, sa_avg_periods
from skewbridge.motions.levels import FACTOR_LIMITS, Level
from skewbridge.motions.record import Vector
from skewbridge.motions.suite import read_entries
from skewbridge.motions.synthesis import Scenario, baker_jayaram_correlation, bssa14
from skewbridge.units import G_MPS2

_UNREADABLE: Final = (  # a file has other contents than expected; the last is of pandas
    *(AttributeError, LookupError, StopIteration, TypeError, ValueError, NotImplementedError),
)
#: Largest relative errors of median and dispersion of PSA at any period from 0.2 to 3 T1.
TOLERANCES: Final = np.array([0.05, 0.10])
MOST_PER_EVENT: Final = 2
# ASSUME errors above 0.9 of a tolerance, and synthetic pairs, cost more (trial runs)
_AIM, _COST_OVER, _COST_SYNTHETIC, _STARTS = 0.9, 20.0, 0.05, 32
BAND_POINTS: Final = 39  # every second one is a period of Sa_avg(T1)
#: Factor on the period of SA within which errors are not checked: the target has no dispersion.
_TOO_NEAR: Final = 1.03
_ROW: Final = ("magnitude", "distance_km", "epsilon", "weight", "level_g")


class Rupture(Scenario):
    """Earthquake and site within the range of BSSA14, which exceeds that of the generator."""

    LIMITS: ClassVar = {"magnitude": (3.0, 8.5), "distance_km": (0.0, 400.0)}


@dataclass(frozen=True, slots=True, kw_only=True, config=text.OPTIONS)
class Cause:
    """Earthquake that contributes to the hazard at a level, with its ``weight`` there."""

    magnitude: Number
    distance_km: Number
    epsilon: Annotated[Number, Field(ge=-6.0, le=6.0)]  # at the level: epsilon-0 of the USGS
    weight: Annotated[Number, Field(gt=0.0)] = 1.0
    level_g: Level | None = None  # None: the level that BSSA14 has at this epsilon

    @model_validator(mode="after")
    def _weight_of_a_level(self) -> Self:
        if self.level_g is None and self.weight != 1.0:
            raise ValueError("weight needs level_g, the same in all earthquakes of a level")
        return self


@dataclass(frozen=True, slots=True, kw_only=True, config=text.OPTIONS)
class Target:
    """Target of a selection; without ``t1_s``, the period of the measure is the bridge's T1."""

    measure: Annotated[str, Field(pattern=r"^(SA|Sa_avg3?)\((\d*\.)?\d+\)$")]
    vs30_mps: Annotated[Number, Field(ge=150.0, le=1500.0)]
    mechanism: Literal["strike_slip", "reverse"] = "strike_slip"
    t1_s: Number | None = None
    levels: Annotated[tuple[Cause, ...], Field(min_length=1)]


class ConditionalSpectrum(NamedTuple):
    """PSA at `BAND_POINTS` periods from 0.2 to 3 T1, then at the periods of the measure."""

    periods_s: Vector
    median_g: Vector
    sigma: Vector  # standard deviation of ln PSA
    weights: Vector  # their product with ln PSA is the logarithm of the measure
    causes: dict[str, float]  # level, means of the earthquakes, level of BSSA14 at this epsilon


def condition(
    mean: Vector, sigma: Vector, rho: Vector, weights: Vector, epsilon: Vector
) -> tuple[Vector, Vector]:
    """Return conditional means and standard deviations of ln PSA, shape (n, periods) each.

    The condition: the weighted sum of ln PSA is epsilon (n,) standard deviations above its mean.
    """
    gain = sigma * ((sigma * weights) @ rho)
    slope = gain / np.sqrt(gain @ weights)[:, None]
    return mean + epsilon[:, None] * slope, np.sqrt(np.maximum(sigma**2 - slope**2, 0.0))


def conditional_spectra(target: Target) -> list[ConditionalSpectrum]:
    """Return the spectrum of each level; `InputError` for values outside the range of BSSA14."""
    period_s = float(target.measure.split("(")[1][:-1])
    averaged_s = sa_avg_periods(period_s) if "avg" in target.measure else np.array([period_s])
    t1_s = target.t1_s or period_s
    periods = np.append(t1_s * np.geomspace(0.2, 3.0, BAND_POINTS), averaged_s)
    if not 0.01 <= periods.min() <= periods.max() <= 10.0:
        span = f"{periods.min():.3g} to {periods.max():.3g} s"
        raise InputError(f"0.2 T1 to 3 T1 and the measure must be within 0.01 to 10 s, got {span}")
    weights = np.append(np.zeros(BAND_POINTS), np.full(averaged_s.size, 1.0 / averaged_s.size))
    rho = baker_jayaram_correlation(periods)
    site: dict[str, Any] = {"vs30_mps": target.vs30_mps, "mechanism": target.mechanism}
    levels, spectra = dict[float, list[Cause]](), list[ConditionalSpectrum]()
    for number, cause in enumerate(target.levels):
        levels.setdefault(cause.level_g or -float(number), []).append(cause)
    for level in levels.values():
        rows = np.array([(c.weight, c.magnitude, c.distance_km, c.epsilon) for c in level])
        ruptures = [Rupture(magnitude=m, distance_km=r, **site) for _, m, r, _ in rows.tolist()]
        tabulated = np.array([bssa14(rupture, SPECTRUM_PERIODS_S) for rupture in ruptures])
        tabulated[:, 0] = np.log(tabulated[:, 0])
        # between tabulated periods within 1 % of the equations, 0.1 to 5 s
        interpolated = PchipInterpolator(np.log(SPECTRUM_PERIODS_S), tabulated, axis=2)
        mean, sigma = np.swapaxes(interpolated(np.log(periods)), 0, 1)
        mean, sigma = condition(mean, sigma, rho, weights, rows[:, 3])
        weight, ln_level = rows[:, 0] / rows[:, 0].sum(), mean @ weights
        bssa14_g = float(np.exp(weight @ ln_level))
        causes = {"level_g": level[0].level_g or bssa14_g, "bssa14_level_g": bssa14_g}
        causes |= zip(_ROW[:3], (weight @ rows[:, 1:]).tolist(), strict=True)
        # ASSUME the models of the hazard differ from BSSA14 by the same factor at all periods
        scaled = mean + (np.log(causes["level_g"]) - ln_level)[:, None]
        average = weight @ scaled
        deviation = np.sqrt(weight @ (sigma**2 + (scaled - average) ** 2))
        spectra.append(ConditionalSpectrum(periods, np.exp(average), deviation, weights, causes))
    return spectra


def read_target(path: Path, overrides: Mapping[str, Any]) -> Target:
    """Return the target in a file: YAML by hand, CSV of OpenQuake, or JSON of the USGS.

    ``overrides`` replace values of the file; a measure selects from a file with several. Raises
    `InputError` for wrong or missing values, such as epsilon.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        values = text.read_mapping(path)
    else:
        table = _openquake(path) if path.suffix.lower() == ".csv" else _usgs(path)
        names = table["measure"].unique().tolist()
        measure = overrides.get("measure", names[0] if len(names) == 1 else None)
        if measure not in names:
            available = ", ".join(names) or "no rates"
            raise text.file_fault(path, f" has {available}: select with --set measure=NAME")
        rows = table.loc[table["measure"] == measure, list(_ROW)].to_dict("records")
        values = {"measure": measure, "levels": rows}
    return text.checked(Target, {**values, **overrides}, path)


def _openquake(path: Path) -> pd.DataFrame:
    """Return a table of measures and `Cause` fields from Mag_Dist_Eps of OpenQuake >= 3.16."""
    names = {"imt": "measure", "iml": "level_g", "mag": "magnitude", "dist": "distance_km"}
    content = io.StringIO(text.read_text(path, text.MAX_CSV_BYTES))
    try:
        table = pd.read_csv(content, comment="#").rename(columns=names).astype({"eps": float})
        (column,) = (name for name in table if name == "mean" or str(name).startswith("rlz"))
        rate = -np.log1p(-np.minimum(table[column], 1.0 - 1.0e-12))
        rows = table.assign(weight=rate, moment=rate * table["eps"])[rate > 0.0]
        cells = rows.groupby(list(names.values()), sort=False)
    except _UNREADABLE as error:
        required = "Mag_Dist_Eps with imt, iml, mag, dist, eps and one column of probabilities"
        raise text.file_fault(path, f" is not the export {required}: {error}") from None
    totals = cells[["weight", "moment"]].sum().reset_index()
    epsilon = (totals["moment"] / totals["weight"]).to_numpy()
    if cells["eps"].max().eq(rows["eps"].max()).all():
        # of all motions above the level (`epsilon_star: false`): the mean is E[x | x > epsilon]
        grid = np.linspace(-4.0, 6.0, 2001)
        epsilon = np.interp(epsilon, norm.pdf(grid) / norm.sf(grid), grid)
    return totals.assign(epsilon=epsilon)


def _usgs(path: Path) -> pd.DataFrame:
    """Return a table of measures and `Cause` fields from a disaggregation of the USGS."""
    names = {"m": "magnitude", "r": "distance_km", "value": "weight"}
    tables: list[pd.DataFrame] = []
    try:
        response = text.read_json(path)["response"]
        metadata = response["metadata"] if isinstance(response, dict) else {}
        for block in response["disaggs"] if metadata else response:
            header = metadata | block | block.get("metadata", {})
            imt = header["imt"]["value"] if isinstance(header["imt"], dict) else header["imt"]
            bins = pd.DataFrame(header["εbins"], columns=["id", "min", "max"]).set_index("id")
            bin_middles = bins.astype(float).mean(axis=1)  # of an open bin: its edge
            total = next(t for t in block["data"] if t.get("component", "Total") == "Total")
            items = [item for group in total["summary"] for item in group["data"]]
            level_g = next(item["value"] for item in items if item.get("units") == "g")
            rows = pd.json_normalize(total["data"], "εdata", ["m", "r"]).rename(columns=names)
            rows = rows.assign(level_g=level_g, epsilon=rows["εbin"].map(bin_middles)).astype(float)
            measure = re.sub(r"^SA(\d+)P(\d+)$", r"SA(\1.\2)", imt)
            tables.append(rows.assign(measure=measure))
        return pd.concat(tables)
    except _UNREADABLE as error:
        problem = " is not a disaggregation of the USGS by magnitude, distance and epsilon"
        raise text.file_fault(path, f"{problem}: {error}") from None


class LevelSelection(NamedTuple):
    """Pairs selected for one level, see `select_pairs`."""

    target: ConditionalSpectrum
    pairs: pd.DataFrame
    summary: dict[str, Any]

    @property
    def doubts(self) -> list[str]:
        """Why the pairs or their level may not serve, in words."""
        level_g, bssa14_g = self.summary["level_g"], self.summary["bssa14_level_g"]
        ratio = level_g / bssa14_g
        inaccurate = f"pairs at {level_g:.3g} g exceed the tolerances (mean 5 %, dispersion 10 %)"
        far = f"level_g {level_g:.3g} is {ratio:.2g} times that of BSSA14 at this epsilon"
        findings = {
            f"{inaccurate}: add candidates": not self.summary["within_tolerances"],
            # ASSUME the hazard of a site is within a factor of 1.5 of this model
            f"{far}: check both; the model may not suit the site": not 1.0 / 1.5 <= ratio <= 1.5,
        }
        return [text for text, applies in findings.items() if applies]


def select_motions(
    target: Path,
    values: Mapping[str, Any],  # keys of the target, which replace those of its file
    sources: Sequence[Path],  # folders of candidates
    count: int,  # pairs at each level
    out: Path,
    without: Path | None = None,  # folder of an earlier selection
) -> list[LevelSelection]:
    """Select pairs for each level of a target file and write them as a folder of motions.

    Raises `InputError` for a wrong target before candidates are read, and for too few candidates.
    """
    target_of_file = read_target(target, values)
    try:
        spectra = conditional_spectra(target_of_file)
    except InputError as error:
        raise text.file_fault(target, f": {error}", **error.details) from None
    writable_file(out / INDEX_NAME)
    used_names = set(read_index_table(without / INDEX_NAME).get("candidate", ())) if without else ()
    candidates = read_candidates(sources, spectra[0].periods_s, count, used_names)
    levels = [LevelSelection(s, *select_pairs(candidates, s, count)) for s in spectra]
    write_selections([level.pairs for level in levels], out)
    return levels


def read_candidates(
    folders: Sequence[Path], periods_s: Vector, count: int, without: Collection[str] = ()
) -> pd.DataFrame:
    """Return a table with entry, motion, ln PSA (g), event and is_synthetic of all candidates.

    A synthetic pair, or one without an event, is an event of its own. Raises `InputError` for fewer
    than ``count`` pairs, names in ``without`` left out, or a name that two folders have.
    """
    all_entries = [entry for folder in folders for entry in list_motions(folder)]
    names = pd.Series([entry.motion_id for entry in all_entries], dtype=str)
    for name in names[names.duplicated()]:
        raise InputError(f"two folders of candidates have the motion {name}: rename one")
    entries = [entry for entry in all_entries if entry.motion_id not in without]
    if not 2 <= count <= len(entries):
        raise InputError(f"count must be from 2 to the {len(entries)} candidates, got {count}")
    motions = read_entries(entries)
    psa_mps2 = [pair_psa(*m.components, m.dt_s, periods_s).rotd50_mps2 for m in motions]
    table = pd.DataFrame({"entry": entries, "motion": motions})
    is_synthetic = np.array(["synthetic:" in m.source for m in motions])
    events = [m.event or m.motion_id for m in motions]
    events = np.where(is_synthetic, [m.motion_id for m in motions], events)
    log_psa = list(np.log(np.array(psa_mps2) / G_MPS2))
    return table.assign(log_psa=log_psa, event=events, is_synthetic=is_synthetic)


def select_pairs(
    candidates: pd.DataFrame, target: ConditionalSpectrum, count: int
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Return the pairs selected for one level, with scale and scaled ln PSA, and a summary.

    Raises `InputError` if too few pairs reach the level with factors of 0.25 to 4.
    """
    level_g, log_psa = target.causes["level_g"], np.stack(candidates["log_psa"].to_list())
    log_factors = np.log(level_g) - log_psa @ target.weights
    scaled = (log_psa + log_factors[:, None])[:, :BAND_POINTS]
    pool = candidates.assign(scale=np.exp(log_factors), level_g=level_g, log_psa=list(scaled))
    pool = pool[np.abs(log_factors) <= np.log(FACTOR_LIMITS[1])]
    if (available := pool["event"].value_counts().clip(upper=MOST_PER_EVENT).sum()) < count:
        low, high = FACTOR_LIMITS
        fault = f"only {available} pairs reach {level_g:.3g} g with factors of {low:g} to {high:g}"
        limit = f"at most {MOST_PER_EVENT} per event"
        raise InputError(f"{fault} and {limit}: {count} are needed; add candidates")
    band, measure = np.split(np.log(target.periods_s), [BAND_POINTS])
    checked = (measure.size > 1) | (np.abs(band - measure[0]) > np.log(_TOO_NEAR))
    median_g, sigma = target.median_g[:BAND_POINTS][checked], target.sigma[:BAND_POINTS][checked]
    error = np.stack(pool["log_psa"].to_list())[:, checked] - np.log(median_g)
    event_and_kind = pool["event"].factorize()[0], pool["is_synthetic"].to_numpy()
    starts = (np.random.default_rng(seed).permutation(len(pool)) for seed in range(_STARTS))
    chosen = min(_improved(error, sigma, *event_and_kind, start, count) for start in starts)[1]
    errors = np.expm1(error[chosen].mean(axis=0)), error[chosen].std(axis=0, ddof=1) / sigma - 1.0
    largest, selected = np.abs(errors).max(axis=1), pool.iloc[chosen]
    return selected, {
        **target.causes,
        "synthetic_share": float(selected["is_synthetic"].mean()),
        "factors": [float(selected["scale"].min()), float(selected["scale"].max())],
        **dict(zip(("mean_error", "dispersion_error"), largest.tolist(), strict=True)),
        "within_tolerances": bool((largest <= TOLERANCES).all()),
    }


def _improved(
    error: Vector, sigma: Vector, event: Index, synthetic: Mask, start: Index, count: int
) -> tuple[float, list[int]]:
    """Select ``count`` candidates, then replace them one by one; return misfit and their numbers.

    ``error`` (n, periods) is ln PSA minus its target; ``start`` (n,) is the order of candidates.
    """
    allowed = pd.Series(event[start]).groupby(event[start]).cumcount() < MOST_PER_EVENT
    selected = start[allowed][:count].tolist()
    misfit, last_misfit = np.inf, np.nan
    while not misfit >= last_misfit:
        last_misfit = misfit
        for replaced in range(count):
            kept = selected[:replaced] + selected[replaced + 1 :]
            mean = (error[kept].sum(axis=0) + error) / count
            squares = (error[kept] ** 2).sum(axis=0) + error**2 - count * mean**2
            scatter = np.sqrt(np.maximum(squares, 0.0) / (count - 1)) / sigma - 1.0
            ratios = np.abs([np.expm1(mean), scatter]) / TOLERANCES[:, None, None]
            costs = ratios**2 / 2.0 / sigma.size + _COST_OVER * np.maximum(ratios - _AIM, 0.0) ** 2
            costs = costs.sum(axis=(0, 2)) + _COST_SYNTHETIC * (synthetic[kept].sum() + synthetic)
            is_full = np.bincount(event[kept], minlength=int(event.max()) + 1) >= MOST_PER_EVENT
            costs[is_full[event]] = costs[kept] = np.inf
            selected[replaced], misfit = int(costs.argmin()), float(costs.min())
    return misfit, selected


def write_selections(selections: Sequence[pd.DataFrame], folder: Path) -> None:
    """Copy the files of the selected pairs to a folder of motions and write its index."""
    rows: list[dict[str, object]] = []
    for number, selection in enumerate(selections, start=1):
        for pair in records_of(selection):
            name, entry = pair["motion"].motion_id, pair["entry"]
            # both components may have the same file name, in different folders
            files = [
                Path(shutil.copy(path, writable_folder(folder / "files" / name / str(n))))
                for n, (path, _) in enumerate(entry.components, 1)
            ]
            row = entry.model_dump(exclude={"components", "licence"})
            row |= index_row(pair["motion"], files, folder) | {"candidate": name}
            row |= {"scale": pair["scale"], "level_g": pair["level_g"]}
            row["motion_id"] = name + (f"_{number}" if len(selections) > 1 else "")
            rows.append(row)
    write_index(folder / INDEX_NAME, rows)
