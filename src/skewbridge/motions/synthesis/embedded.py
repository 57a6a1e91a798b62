"""Synthetic suites on disk: that of a user's scenario, and the one shipped with the project.

The latter has 40 pairs, 20 s of shaking and 5 s of free vibration.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.motions.conditioning import (
    add_free_vibration,
    cut_to_strongest,
    effect_on_measures,
    trim_quiet_ends,
)
from skewbridge.motions.index import INDEX_NAME
from skewbridge.motions.intensity import motion_measures, pair_arias_build_up
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.scaling import LEVEL_RANGE_G, block_factors
from skewbridge.motions.synthesis.generate import SynthesisOptions, synthesize
from skewbridge.motions.synthesis.scenario import Scenario
from skewbridge.motions.write import index_row, write_at2, write_index

# ASSUME one strong strike-slip earthquake near the bridge on firm soil: its median Sa_avg is the
# middle of the default levels (0.1 to 1.5 g), which keeps scale factors near 1.
SCENARIO: Final = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
SEED: Final = 2023
COUNT: Final = 40
SHAKING_S: Final = 20.0
FREE_VIBRATION_S: Final = 5.0
# ASSUME motions that shake much longer than the window are left out: what is kept of the others is
# nearly the whole motion, at the price of a suite without the longest durations.
MIN_ARIAS_KEPT: Final = 0.95
LICENCE: Final = "BSD-3-Clause"
MAX_COUNT: Final = 1000


def default_motions() -> Iterator[tuple[GroundMotion, GroundMotion]]:
    """Yield each motion of the default suite, as synthesized and as cut."""
    found = index = 0
    while found < COUNT:
        whole = synthesize(SCENARIO, index=index, seed=SEED)
        cut = cut_to_strongest(whole, SHAKING_S, FREE_VIBRATION_S)
        if pair_arias_build_up(cut)[-1] >= MIN_ARIAS_KEPT * pair_arias_build_up(whole)[-1]:
            found += 1
            yield whole, cut
        index += 1


def write_default_suite(folder: Path, t1_s: float) -> list[dict[str, float]]:
    """Write the default suite: `synthetic/*.AT2` and `index.csv` in a folder.

    Args:
        folder: Where to write.
        t1_s: Conditioning period of osb1, for the scale factors; kept in the index.

    Returns:
        The effect of the cut on each motion, see `effect_on_measures`.
    """
    effects: list[dict[str, float]] = []
    rows: list[dict[str, object]] = []
    levels_g: list[float] = []
    for whole, cut in default_motions():
        effects.append(effect_on_measures(whole, cut))
        files = write_at2(cut, folder / "synthetic")
        rows.append(_row(cut, files, folder))
        # a factor is that of the motion as written, with 8 digits
        levels_g.append(motion_measures(read_motion(*files), t1_s)["im_saavg_rotd50_g"])
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


def _row(motion: GroundMotion, files: tuple[Path, Path], folder: Path) -> dict[str, object]:
    """Return the index row of a synthetic motion written to two files."""
    return index_row(motion, files, folder) | {"unit": "g", "licence": LICENCE}
