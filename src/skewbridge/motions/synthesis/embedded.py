"""Synthetic suites on disk: that of a user's scenario, and the one shipped with the project.

The latter has 128 pairs, 20 s of shaking and 5 s of free vibration. The first 40 are stored as
files; the index has the numbers of the others, which are made from them where a study needs them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.conditioning import (
    add_free_vibration,
    cut_to_strongest,
    effect_on_measures,
    trim_quiet_ends,
)
from skewbridge.motions.index import INDEX_NAME, MADE_FROM
from skewbridge.motions.intensity import motion_measures, pair_arias_build_up
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.scaling import block_factors
from skewbridge.motions.settings import LEVEL_MEASURE, LEVEL_RANGE_G
from skewbridge.motions.synthesis.generate import SynthesisOptions, drawn_parameters, synthesize
from skewbridge.motions.synthesis.process import meets_its_times
from skewbridge.motions.synthesis.scenario import Scenario
from skewbridge.motions.write import as_files_digest, index_row, write_at2, write_index
from skewbridge.units import G_MPS2

# ASSUME one strong strike-slip earthquake near the bridge on firm soil: its median Sa_avg is the
# middle of the default levels (0.07 to 2.25 g), which keeps scale factors near 1.
SCENARIO: Final = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
SEED: Final = 2023
COUNT: Final = 128
STORED: Final = 40
SHAKING_S: Final = 20.0
FREE_VIBRATION_S: Final = 5.0
# ASSUME motions that shake much longer than the window are left out: what is kept of the others is
# nearly the whole motion, at the price of a suite without the longest durations.
MIN_ARIAS_KEPT: Final = 0.95
STEPS_PER_G: Final = 1.0e7  # of the values of a motion that is made
# The values of a motion differ by 1e-14 g between processors, found with and without the vector
# instructions of numpy and OpenBLAS.
CLEAR_OF_TIES_G: Final = 1.0e-12
LICENCE: Final = "BSD-3-Clause"
MAX_COUNT: Final = 1000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DefaultMotion:
    """One motion of the default suite.

    Attributes:
        number: Its number in the stream of the seed, from 1.
        whole: The motion as synthesized.
        cut: The motion of the suite.
        is_stored: Whether its files lie in the folder; else it is made by `made_motion`.
    """

    number: int
    whole: GroundMotion
    cut: GroundMotion
    is_stored: bool


def default_motions(count: int = COUNT) -> Iterator[DefaultMotion]:
    """Yield the first motions of the default suite; none depends on how many there are."""
    found = number = 0
    while found < count:
        number += 1
        is_stored = found < STORED
        if not is_stored and not _has_exact_envelopes(number):
            continue
        whole, cut = _synthesized(number)
        kept = pair_arias_build_up(cut)[-1] / pair_arias_build_up(whole)[-1]
        if kept >= MIN_ARIAS_KEPT and (is_stored or _is_clear_of_ties(cut)):
            found += 1
            used = cut if is_stored else _rounded(cut)
            yield DefaultMotion(number=number, whole=whole, cut=used, is_stored=is_stored)


def made_motion(number: int) -> GroundMotion:
    """Return a motion of the default suite that has no files, with the digest they would have.

    Its digest, and with it the keys of the analyses, are the same on every processor, though the
    last digits of exp, sin and the Fourier transform are not. Values are whole multiples of
    1e-7 g, and the suite has only such numbers that no value is where a difference of 1e-12 g
    could round it the other way, and that the envelopes are exact, see `meets_its_times`.

    Args:
        number: Its number in the stream of the seed, from 1.
    """
    motion = _rounded(_synthesized(number)[1])
    return replace(motion, sha256=as_files_digest(motion))


def write_default_suite(folder: Path, t1_s: float) -> list[dict[str, float]]:
    """Write the default suite: `index.csv` and, of its first motions, `synthetic/*.AT2`.

    Args:
        folder: Where to write.
        t1_s: Conditioning period of osb1, for the scale factors; kept in the index.

    Returns:
        The effect of the cut on each motion, see `effect_on_measures`.
    """
    effects: list[dict[str, float]] = []
    rows: list[dict[str, object]] = []
    levels_g: list[float] = []
    for each in default_motions():
        effects.append(effect_on_measures(each.whole, each.cut))
        if each.is_stored:
            files = write_at2(each.cut, folder / "synthetic")
            rows.append(_row(each.cut, files, folder))
            motion = read_motion(*files)  # a factor is that of the motion as written, with 8 digits
        else:
            motion = made_motion(each.number)
            rows.append(_row(motion, (), folder) | {MADE_FROM: each.number})
        levels_g.append(motion_measures(motion, t1_s)[LEVEL_MEASURE])
    for row, factor in zip(rows, block_factors(levels_g), strict=True):
        row["scale"] = float(f"{factor:.6g}")
        row["scale_t1_s"] = t1_s
        row["scale_low_g"], row["scale_high_g"] = LEVEL_RANGE_G
    write_index(folder / INDEX_NAME, rows)
    return effects


def write_synthetic_suite(
    folder: Path,
    scenario: Scenario,
    *,
    count: int,
    seed: int,
    options: SynthesisOptions,
    shaking_s: float | None = None,
    free_vibration_s: float = 0.0,
) -> Path:
    """Write pairs as PEER files with an `index.csv`; return the path of the index.

    Args:
        folder: Where to write; an index in it is replaced.
        scenario: Earthquake and site.
        count: Number of pairs.
        seed: Seed; pair i is the same whatever the count.
        options: Calibration, orientation, time step.
        shaking_s: Keep only the strongest part of this length; None cuts only the quiet ends.
        free_vibration_s: Zeros added at the end.

    Raises:
        InputError: A count or length outside its limits, an unwritable folder.
    """
    if not 1 <= count <= MAX_COUNT:
        raise InputError(f"count must be within 1 to {MAX_COUNT}, got {count}")
    rows: list[dict[str, object]] = []
    for index in range(count):
        motion = synthesize(scenario, index=index, seed=seed, options=options)
        if shaking_s is None:
            motion = add_free_vibration(trim_quiet_ends(motion), free_vibration_s)
        else:
            motion = cut_to_strongest(motion, shaking_s, free_vibration_s)
        rows.append(_row(motion, write_at2(motion, folder), folder))
    write_index(folder / INDEX_NAME, rows)
    return folder / INDEX_NAME


def _synthesized(number: int) -> tuple[GroundMotion, GroundMotion]:
    """Return a motion of the stream, whole and cut."""
    whole = synthesize(SCENARIO, index=number - 1, seed=SEED)
    return whole, cut_to_strongest(whole, SHAKING_S, FREE_VIBRATION_S)


def _has_exact_envelopes(number: int) -> bool:
    drawn, _ = drawn_parameters(SCENARIO, index=number - 1, seed=SEED)
    return all(map(meets_its_times, (drawn.component_1, drawn.component_2)))


def _rounded(motion: GroundMotion) -> GroundMotion:
    return motion.mapped(_in_whole_steps)


def _in_whole_steps(accel_mps2: Vector) -> Vector:
    # The sum with zero takes the sign off a zero, which is a matter of the processor, too.
    return (np.rint(accel_mps2 / G_MPS2 * STEPS_PER_G) + 0.0) / STEPS_PER_G * G_MPS2


def _is_clear_of_ties(motion: GroundMotion) -> bool:
    """Say whether no value lies where another processor could round it the other way."""
    steps = np.concatenate(motion.components) / G_MPS2 * STEPS_PER_G
    from_tie_g = np.abs(steps - np.floor(steps) - 0.5) / STEPS_PER_G
    return bool(from_tie_g.min() > CLEAR_OF_TIES_G)


def _row(motion: GroundMotion, files: Sequence[Path], folder: Path) -> dict[str, object]:
    """Return the index row of a synthetic motion written to two files, or made."""
    return index_row(motion, files, folder) | {"unit": "g", "licence": LICENCE}
