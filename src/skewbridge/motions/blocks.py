"""Blocks of a study: the variants that are analysed under each motion.

With `motions.blocks`, a motion is a block of analyses (an incomplete block design). It runs all
values of some axes, such as skew, in one or two cells: combinations of the other axes of the grid.
Skew effects scatter most from motion to motion and need many motions, each in any cell. Effects of
the other axes need motions that run all cells, but fewer, because they scatter less.

References:
    Cochran and Cox (1957), Experimental Designs, chapter 9 (balanced incomplete blocks).
    Neyman (1934), J. R. Stat. Soc. 97(4):558-625: allocation in proportion to the scatter.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import combinations, product
from math import floor
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.motions.levels import BLOCK, LEVEL_MEASURE, BlocksConfig, MotionsConfig
from skewbridge.motions.record import SuiteMotion
from skewbridge.variant.grid import GridConfig, cells_of

#: Motion, scale factor and incidence of an analysis.
type Run = tuple[str, float, float]
#: Suite, motion, scale factor and level (Sa_avg in g) of a row of a suite.
type Placed = tuple[str, str, float, float]

_ROUNDING: Final = 1e-9


def placed(suite: Iterable[SuiteMotion]) -> list[Placed]:
    """Return suite name, motion name, scale factor and Sa_avg in g of each motion of a suite."""
    return [(m.suite, m.motion.motion_id, m.scale, m.measures[LEVEL_MEASURE]) for m in suite]


def unread(count: int, suite: str = "") -> list[Placed]:
    """Return rows like those of `placed` for motions not yet read; levels are positions from 0."""
    return [(suite, f"{suite}{number}", 1.0, float(number)) for number in range(count)]


class _Counts:
    """Numbers of earlier runs by cell, from which `assign` chooses the cells of the next motion."""

    def __init__(self, cells: int, incidences: int) -> None:
        self.in_band = np.zeros((BLOCK, cells), dtype=np.int64)
        self.at_incidence = np.zeros((incidences, cells), dtype=np.int64)
        self.at_once = np.zeros((cells, cells), dtype=np.int64)  # pairs at the same incidence
        self.of_pair = np.zeros((cells, cells), dtype=np.int64)  # pairs that share a motion

    def imbalance(self, rank: int, chosen: Mapping[int, tuple[int, ...]]) -> tuple[int, ...]:
        """Return counts of earlier runs in the cells ``chosen`` at each incidence, and in pairs."""
        cells = [cell for group in chosen.values() for cell in group]
        at_once = [pair for group in chosen.values() for pair in combinations(group, 2)]
        sums = [self.at_incidence[angle, list(group)].sum() for angle, group in chosen.items()]
        return (
            len(cells) - len(set(cells)),
            int(self.in_band[rank, cells].sum()),
            sum(int(self.at_once[pair]) for pair in at_once),
            sum(int(self.of_pair[pair]) for pair in combinations(cells, 2)),
            int(self.in_band[:, cells].sum()),
            int(sum(sums)),
        )

    def add(self, rank: int, chosen: Mapping[int, tuple[int, ...]]) -> None:
        """Count a motion of this rank in the cells ``chosen``, keyed by number of the incidence."""
        cells = [cell for group in chosen.values() for cell in group]
        np.add.at(self.in_band[rank], cells, 1)
        for angle, group in chosen.items():
            self.at_incidence[angle, list(group)] += 1
            for pair in combinations(group, 2):
                self.at_once[pair] += 1
        for cell_1, cell_2 in combinations(cells, 2):
            self.of_pair[[cell_1, cell_2], [cell_2, cell_1]] += 1


def assign(
    levels_g: Sequence[float], cells: int, incidences: int, blocks: BlocksConfig
) -> NDArray[np.bool_]:
    """Return the cells in which each motion runs at each incidence.

    The array has the shape (motions, incidences, cells). The motions of each group of `BLOCK`
    consecutive motions are ordered by level; motions of equal rank form a band. Each motion gets
    the cells that keep, in this order, the numbers of runs of the cells in its band, of pairs of
    cells at the same incidence of a motion, of pairs that share a motion, of the cells, and of the
    cells at each incidence as equal as possible. The incidences of a motion have different cells
    where possible. At regular intervals a motion also runs all cells at one incidence, which
    alternates; such motions are balanced among themselves. Added motions do not change full groups.
    """
    levels = np.asarray(levels_g, dtype=np.float64)
    runs = np.zeros((levels.size, incidences, cells), dtype=np.bool_)
    choices = list(combinations(range(cells), min(blocks.cells_per_motion, cells)))
    few_cells, all_cells = _Counts(cells, incidences), _Counts(cells, incidences)
    n_complete = 0
    for position in range(levels.size):
        start, rank = position - position % BLOCK, position % BLOCK
        motion = start + np.argsort(levels[start : start + BLOCK], kind="stable")[rank]
        counts, angles = few_cells, list(range(incidences))
        if floor((position + 1) * blocks.complete_share + _ROUNDING) > n_complete:
            runs[motion, angles.pop(n_complete % incidences)] = True
            counts, n_complete = all_cells, n_complete + 1
        options = product(choices, repeat=len(angles))
        by_angle = (dict(zip(angles, option, strict=True)) for option in options)
        chosen = min(by_angle, key=partial(counts.imbalance, rank))
        counts.add(rank, chosen)
        for incidence, group in chosen.items():
            runs[motion, incidence, list(group)] = True
    return runs


def planned_runs(
    grid: GridConfig, motions: MotionsConfig, rows: Sequence[Placed]
) -> dict[str, set[Run]]:
    """Return the analyses of each variant, keyed by its name: all, or those of `motions.blocks`.

    Each suite is balanced separately. A variant that stands for several cells (an abutment model
    without friction, for example) runs all motions of these cells.
    """
    blocks, angles = motions.blocks, motions.incidence_deg
    n_cells, cells = cells_of(grid, blocks.within if blocks else ())
    runs = np.ones((len(rows), len(angles), n_cells), dtype=np.bool_)
    for suite in {row[0] for row in rows}:
        indices = [i for i, row in enumerate(rows) if row[0] == suite]
        if blocks:
            runs[indices] = assign([rows[i][3] for i in indices], n_cells, len(angles), blocks)
    return {
        slug: {
            (*rows[row][1:3], angles[angle])
            for row, angle in np.argwhere(runs[:, :, cell_numbers].any(axis=2)).tolist()
        }
        for slug, cell_numbers in cells.items()
    }
