"""Selection of pairs whose spectra follow a conditional spectrum.

Each pair is scaled to the level. As in the greedy step of Baker and Lee (2018, J. Earthq. Eng.
22(4)), pairs are replaced one by one while mean and deviation of ln PSA approach the target.
"""

import shutil
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.tables import Index, Mask, records_of
from skewbridge.files.text import writable_file, writable_folder
from skewbridge.motions.conditional import (
    BAND_POINTS,
    ConditionalSpectrum,
    conditional_spectra,
    read_target,
)
from skewbridge.motions.folder import (
    INDEX_NAME,
    index_row,
    list_motions,
    read_index_table,
    write_index,
)
from skewbridge.motions.levels import FACTOR_LIMITS
from skewbridge.motions.record import Vector
from skewbridge.motions.spectrum import pair_psa
from skewbridge.motions.suite import read_entries
from skewbridge.units import G_MPS2

#: Largest relative errors of median and dispersion of PSA at any period from 0.2 to 3 T1.
TOLERANCES: Final = np.array([0.05, 0.10])
MOST_PER_EVENT: Final = 2
# ASSUME errors above 0.9 of a tolerance, and synthetic pairs, cost more (trial runs)
_AIM, _COST_OVER, _COST_SYNTHETIC, _STARTS = 0.9, 20.0, 0.05, 32


class LevelSelection(NamedTuple):
    """Pairs selected for one level, see `select_pairs`."""

    target: ConditionalSpectrum
    pairs: pd.DataFrame
    summary: dict[str, Any]


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
    spectra = conditional_spectra(read_target(target, values))
    writable_file(out / INDEX_NAME)
    used = set(read_index_table(without / INDEX_NAME).get("candidate", ())) if without else ()
    candidates = read_candidates(sources, spectra[0].periods_s, count, used)
    levels = [LevelSelection(s, *select_pairs(candidates, s, count)) for s in spectra]
    write_selections([level.pairs for level in levels], out)
    return levels


def read_candidates(
    folders: Sequence[Path], periods_s: Vector, count: int, without: Collection[str] = ()
) -> pd.DataFrame:
    """Return entry, motion, ln PSA (g), event and kind of the pairs of folders and suites.

    A synthetic pair, or one without an event, is an event of its own. Raises `InputError` for fewer
    than ``count`` pairs, names in ``without`` left out, or a name that two folders have.
    """
    all_entries = [entry for folder in folders for entry in list_motions(folder)]
    if len({entry.motion_id for entry in all_entries}) < len(all_entries):
        raise InputError("two folders of candidates have motions of the same name: rename them")
    entries = [entry for entry in all_entries if entry.motion_id not in without]
    if not 2 <= count <= len(entries):
        raise InputError(f"count must be within 2 and the {len(entries)} candidates, got {count}")
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
    """Return the candidates of one level with factor and ln PSA of the scaled pair, and a summary.

    Raises `InputError` if too few pairs reach the level with factors of 1/4 to 4.
    """
    level_g, log_psa = target.causes["level_g"], np.stack(candidates["log_psa"].to_list())
    log_factors = np.log(level_g) - log_psa @ target.weights
    scaled = (log_psa + log_factors[:, None])[:, :BAND_POINTS]
    pool = candidates.assign(scale=np.exp(log_factors), level_g=level_g, log_psa=list(scaled))
    pool = pool[np.abs(log_factors) <= np.log(FACTOR_LIMITS[1])]
    if (available := pool["event"].value_counts().clip(upper=MOST_PER_EVENT).sum()) < count:
        reach = f"only {available} pairs reach {level_g:.3g} g with factors of 1/4 to 4 and"
        raise InputError(f"{reach} {MOST_PER_EVENT} per event: {count} are needed")
    sigma = target.sigma[:BAND_POINTS]
    error = np.stack(pool["log_psa"].to_list()) - np.log(target.median_g[:BAND_POINTS])
    event_and_kind = pool["event"].factorize()[0], pool["is_synthetic"].to_numpy()
    starts = (np.random.default_rng(seed).permutation(len(pool)) for seed in range(_STARTS))
    best = min(_improved(error, sigma, *event_and_kind, start, count) for start in starts)[1]
    errors = np.expm1(error[best].mean(axis=0)), error[best].std(axis=0, ddof=1) / sigma - 1.0
    largest, selected = np.abs(errors).max(axis=1), pool.iloc[best]
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
    """Replace selected pairs one at a time until that no longer helps; return misfit and rows."""
    first = pd.Series(event[start]).groupby(event[start]).cumcount() < MOST_PER_EVENT
    selected = start[first][:count].tolist()
    misfit, before = np.inf, np.nan
    while not misfit >= before:
        before = misfit
        for replaced in range(count):
            kept = selected[:replaced] + selected[replaced + 1 :]
            mean = (error[kept].sum(axis=0) + error) / count
            squares = (error[kept] ** 2).sum(axis=0) + error**2 - count * mean**2
            scatter = np.sqrt(np.maximum(squares, 0.0) / (count - 1)) / sigma - 1.0
            shares = np.abs([np.expm1(mean), scatter]) / TOLERANCES[:, None, None]
            costs = shares**2 / 2.0 / sigma.size + _COST_OVER * np.maximum(shares - _AIM, 0.0) ** 2
            costs = costs.sum(axis=(0, 2)) + _COST_SYNTHETIC * (synthetic[kept].sum() + synthetic)
            is_full = np.bincount(event[kept], minlength=int(event.max()) + 1) >= MOST_PER_EVENT
            costs[is_full[event]] = costs[kept] = np.inf
            selected[replaced], misfit = int(costs.argmin()), float(costs.min())
    return misfit, selected


def write_selections(selections: Sequence[pd.DataFrame], folder: Path) -> None:
    """Write index and copied files of the pairs, a folder of motions."""
    rows: list[dict[str, object]] = []
    for number, selection in enumerate(selections, start=1):
        for pair in records_of(selection):
            name, entry = pair["motion"].motion_id, pair["entry"]
            target_folder, paths = folder / "files" / name, [path for path, _ in entry.components]
            files = [Path(shutil.copy(path, writable_folder(target_folder))) for path in paths]
            row = entry.model_dump(exclude={"components", "licence"})
            row |= index_row(pair["motion"], files, folder) | {"candidate": name}
            row |= {"scale": pair["scale"], "level_g": pair["level_g"]}
            row["motion_id"] = name + (f"_{number}" if len(selections) > 1 else "")
            rows.append(row)
    write_index(folder / INDEX_NAME, rows)
