"""Extra seat length over skew, for `docs/howto/critical_skew.md`.

`python docs/critical_skew.py` reads the study `docs/data/critical_skew.yaml`, writes
`docs/data/critical_skew.csv` and prints the table of the page.
"""

import sys
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
from scipy.stats import t

from skewbridge.files.tables import read_frame

DATA: Final = Path("docs/data/critical_skew.csv")
STUDY: Final = Path("results/critical_skew/demands.parquet")


def extra_seat(demands: pd.DataFrame) -> pd.DataFrame:
    """Return unseating displacements and changes in mm, with 90 % intervals over motions.

    Each motion counts with its mean over incidences. ``extra`` is the change from skew 0, ``step``
    that from the next smaller skew.
    """
    rows: list[dict[str, object]] = []
    wide = demands.pivot_table("unseating_m", ["bridge", "motion_id"], "skew_deg") * 1000.0
    for bridge, seats_mm in wide.groupby("bridge"):
        for skew_deg in seats_mm:
            row = {"bridge": bridge, "skew_deg": skew_deg, "seat_mm": seats_mm[skew_deg].mean()}
            before = seats_mm.columns[max(seats_mm.columns.get_loc(skew_deg) - 1, 0)]
            for name, start in (("extra", seats_mm.columns[0]), ("step", before)):
                change = seats_mm[skew_deg] - seats_mm[start]
                half = t.ppf(0.95, len(change) - 1) * change.sem()
                ends = change.mean() + np.array([0.0, -half, half])
                row |= dict(zip((name, f"{name}_low", f"{name}_high"), ends, strict=True))
            rows.append(row | {"n_motions": len(seats_mm)})
    return pd.DataFrame(rows)


def table_text(table: pd.DataFrame) -> str:
    """Return the Markdown table of the page: extra seat length by skew and bridge."""
    cells = [f"{r.extra:.0f} ({r.extra_low:.0f} to {r.extra_high:.0f})" for r in table.itertuples()]
    shown = table.assign(cell=cells).pivot_table("cell", "skew_deg", "bridge", aggfunc="first")
    lines = [f"| skew (degrees) | {' | '.join(shown)} |", "|---|" + "---|" * len(shown.columns)]
    rows = shown.iloc[1:].iterrows()
    return "\n".join([*lines, *(f"| {skew:g} | {' | '.join(row)} |" for skew, row in rows)])


if __name__ == "__main__":
    extra_seat(read_frame(STUDY)).round(2).to_csv(DATA, index=False)
    sys.stdout.write(f"{table_text(pd.read_csv(DATA))}\n")
