"""Selection of pairs whose spectra follow a conditional spectrum.

Each pair is scaled to the level. As in the greedy step of Baker and Lee (2018, J. Earthq. Eng.
22(4)), pairs are replaced one by one while mean and deviation of ln PSA approach the target.
"""

import shutil
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.tables import Index, Mask
from skewbridge.files.text import writable_folder
from skewbridge.motions.conditional import BAND_POINTS, ConditionalSpectrum
from skewbridge.motions.folder import INDEX_NAME, IndexEntry, index_row, list_motions, write_index
from skewbridge.motions.levels import FACTOR_LIMITS
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.spectrum import pair_psa
from skewbridge.motions.suite import read_entries
from skewbridge.units import G_MPS2

#: Largest relative errors of median and dispersion of PSA at any period from 0.2 to 3 T1.
TOLERANCES: Final = np.array([0.05, 0.10])
MOST_PER_EVENT: Final = 2
# ASSUME errors above 0.9 of a tolerance, and synthetic pairs, cost more (trial runs)
_AIM, _COST_OVER, _COST_SYNTHETIC, _STARTS = 0.9, 20.0, 0.05, 32


class Candidate(NamedTuple):
    """A pair and its ln PSA in g; a pair without event is an event of its own, as if synthetic."""

    entry: IndexEntry
    motion: GroundMotion
    log_psa: Vector
    is_synthetic: bool
    event: str


class Selection(NamedTuple):
    """Pairs of one level, their factors and scaled PSA (pairs, BAND_POINTS), row of the table."""

    chosen: list[Candidate]
    factors: Vector
    psa_g: Vector
    summary: dict[str, Any]


def read_candidates(
    folders: Sequence[Path], periods_s: Vector, count: int, without: Collection[str] = ()
) -> list[Candidate]:
    """Return the pairs of folders and suites of `p695.SUITES` except those ``without`` names.

    Raises `InputError` for fewer than ``count`` pairs, or a name that two folders have.
    """
    listed = [entry for folder in folders for entry in list_motions(folder)]
    entries = {entry.motion_id: entry for entry in listed if entry.motion_id not in without}
    if len({entry.motion_id for entry in listed}) < len(listed):
        raise InputError("two folders of candidates have motions of the same name: rename them")
    if not 2 <= count <= len(entries):
        raise InputError(f"count must be within 2 and the {len(entries)} candidates, got {count}")
    candidates: list[Candidate] = []
    for motion in read_entries(entries.values()):
        psa_mps2 = pair_psa(*motion.components, motion.dt_s, periods_s).rotd50_mps2
        made = "synthetic:" in motion.source
        event = "" if made else motion.event
        own = (np.log(psa_mps2 / G_MPS2), made, event or motion.motion_id)
        candidates.append(Candidate(entries[motion.motion_id], motion, *own))
    return candidates


def select_pairs(
    candidates: Sequence[Candidate], target: ConditionalSpectrum, count: int
) -> Selection:
    """Return the pairs of one level, at most `MOST_PER_EVENT` of an earthquake.

    Raises `InputError` if too few pairs reach the level with factors of 1/4 to 4.
    """
    log_psa = np.array([own.log_psa for own in candidates])
    log_factors = np.log(target.causes["level_g"]) - log_psa @ target.weights
    usable = np.flatnonzero(np.abs(log_factors) <= np.log(FACTOR_LIMITS[1]))
    candidates = [candidates[n] for n in usable.tolist()]
    event = np.unique([own.event for own in candidates], return_inverse=True)[1]
    most = int(np.minimum(np.bincount(event), MOST_PER_EVENT).sum())
    if most < count:
        reach = f"only {most} pairs reach {target.causes['level_g']:.3g} g, factors of 1/4 to 4 and"
        raise InputError(f"{reach} {MOST_PER_EVENT} per event: {count} are needed")
    mean, sigma = np.log(target.median_g[:BAND_POINTS]), target.sigma[:BAND_POINTS]
    away = (log_psa + log_factors[:, None])[usable, :BAND_POINTS] - mean
    synthetic = np.array([own.is_synthetic for own in candidates])
    starts = (np.random.default_rng(seed).permutation(usable.size) for seed in range(_STARTS))
    best = min(_improved(away, sigma, event, synthetic, start, count) for start in starts)[1]
    factors = np.exp(log_factors[usable[best]])
    errors = np.expm1(away[best].mean(axis=0)), away[best].std(axis=0, ddof=1) / sigma - 1.0
    largest = np.abs(errors).max(axis=1)
    summary = {
        **target.causes,
        "synthetic_share": float(synthetic[best].mean()),
        "factors": [float(factors.min()), float(factors.max())],
        **dict(zip(("mean_error", "dispersion_error"), largest.tolist(), strict=True)),
        "within_tolerances": bool((largest <= TOLERANCES).all()),
    }
    return Selection([candidates[n] for n in best], factors, np.exp(away[best] + mean), summary)


def _improved(
    away: Vector, sigma: Vector, event: Index, synthetic: Mask, start: Index, count: int
) -> tuple[float, list[int]]:
    """Return misfit and rows of ``away`` (pairs, periods) that no single replacement improves."""
    first = pd.Series(event[start]).groupby(event[start]).cumcount() < MOST_PER_EVENT
    chosen = start[first][:count].tolist()
    misfit, before = np.inf, np.nan
    while not misfit >= before:
        before = misfit
        for place in range(count):
            others = chosen[:place] + chosen[place + 1 :]
            mean = (away[others].sum(axis=0) + away) / count
            squares = (away[others] ** 2).sum(axis=0) + away**2 - count * mean**2
            scatter = np.sqrt(np.maximum(squares, 0.0) / (count - 1)) / sigma - 1.0
            shares = np.abs([np.expm1(mean), scatter]) / TOLERANCES[:, None, None]
            costs = shares**2 / 2.0 / sigma.size + _COST_OVER * np.maximum(shares - _AIM, 0.0) ** 2
            costs = costs.sum(axis=(0, 2)) + _COST_SYNTHETIC * (synthetic[others].sum() + synthetic)
            full = np.bincount(event[others], minlength=int(event.max()) + 1) >= MOST_PER_EVENT
            costs[full[event]] = costs[others] = np.inf
            chosen[place], misfit = int(costs.argmin()), float(costs.min())
    return misfit, chosen


def write_selections(selections: Sequence[Selection], folder: Path) -> Path:
    """Write index and copied files of the pairs, a folder of motions; return the index."""
    rows: list[dict[str, object]] = []
    for number, selection in enumerate(selections, start=1):
        for (entry, motion, *_), factor in zip(selection.chosen, selection.factors, strict=True):
            own = folder / "files" / motion.motion_id
            paths = [path for path, _ in entry.components]
            files = [Path(shutil.copy(path, writable_folder(own))) for path in paths]
            name = motion.motion_id + (f"_{number}" if len(selections) > 1 else "")
            row = entry.model_dump(exclude={"components", "licence"})
            row |= index_row(motion, files, folder) | {"motion_id": name, "scale": float(factor)}
            row |= {"candidate": motion.motion_id, "level_g": selection.summary["level_g"]}
            rows.append(row)
    write_index(folder / INDEX_NAME, rows)
    return folder / INDEX_NAME
