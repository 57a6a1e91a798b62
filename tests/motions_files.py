"""Small motion folders for the tests of the motions package."""

from pathlib import Path

import numpy as np
import pandas as pd

HEADER = """PEER NGA STRONG MOTION DATABASE RECORD
Quake, 1/17/1994, Station, {azimuth}
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= {npts:6d}, DT= {dt:.4f} SEC
"""


def at2_text(values_g: np.ndarray, dt_s: float = 0.01, azimuth: int = 90) -> str:
    """Return the text of a PEER file."""
    header = HEADER.format(npts=len(values_g), dt=dt_s, azimuth=azimuth)
    lines = (values_g[i : i + 5] for i in range(0, len(values_g), 5))
    rows = ["".join(f"{value:15.7E}" for value in line) for line in lines]
    return header + "\n".join(rows) + "\n"


def shaken_g(seed: int, npts: int = 400) -> np.ndarray:
    """Return a short record in g that ends at rest."""
    rng = np.random.default_rng(seed)
    velocity = np.cumsum(rng.standard_normal(npts)) * np.hanning(npts) ** 2
    accel = np.diff(velocity, prepend=0.0)
    return 0.3 * accel / np.abs(accel).max()


def make_pairs(folder: Path, count: int) -> list[tuple[Path, Path]]:
    """Write some pairs `q0_h1.AT2`, `q0_h2.AT2`, ... and return their paths."""
    pairs = []
    for i in range(count):
        files = (folder / f"q{i}_h1.AT2", folder / f"q{i}_h2.AT2")
        for component, path in enumerate(files):
            path.write_text(at2_text(shaken_g(10 * i + component)))
        pairs.append(files)
    return pairs


def index_of(folder: Path, pairs: list[tuple[Path, Path]], **columns: list) -> Path:
    """Write an index of some pairs with further columns."""
    given = {
        "motion_id": [first.stem.removesuffix("_h1") for first, _ in pairs],
        "file_1": [first.name for first, _ in pairs],
        "file_2": [second.name for _, second in pairs],
    }
    table = pd.DataFrame(given | columns)
    table.to_csv(folder / "index.csv", index=False)
    return folder / "index.csv"
