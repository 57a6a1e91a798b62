"""Tables and figures for the page on the recorded bridge.

`python docs/recorded_tables.py FOLDER` writes tables in `docs/data` and figures in
`docs/theory` from the files of `skewbridge verify painter --records DIR --out FOLDER`.
"""

import shutil
import sys
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.files.tables import read_frame

ROOT: Final = Path(__file__).parents[1]
DATA: Final = ROOT / "docs" / "data"
THEORY: Final = ROOT / "docs" / "theory"
#: Event of the figure of histories.
SHOWN: Final = "1992-04-25"


def events_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one row per event and quantity: recorded peak, and predictions divided by it."""
    quantity = rows["quantity"].str.partition(" ")[2]
    ratio = {
        name: (rows[name] / rows["reference"]).round(2) for name in ("value", "null", "uniform")
    }
    return pd.DataFrame(
        {
            "event": rows["event"].str[:4] + " " + rows["kind"],
            "quantity": quantity,
            "recorded": rows["reference"].map("{:.3g}".format),
            "predicted / recorded": ratio["value"],
            "correlation": rows["correlation"].round(2),
            "error": rows["error"].round(2),
            "null": ratio["null"],
            "its correlation": rows["null_correlation"].round(2),
            "uniform input": ratio["uniform"],
            "its correlation ": rows["uniform_correlation"].round(2),
            "result": rows["pass"].map({True: "", False: "miss"}),
        }
    )


def changes_table(changes: pd.DataFrame) -> pd.DataFrame:
    """Return the error of each changed model, one column per event."""
    costs = changes.drop_duplicates(["event", "model"])
    table = costs.pivot_table(index="model", columns="event", values="cost", sort=False).round(2)
    drift = changes[changes["quantity"] == "bent drift across"]
    shown = drift[drift["event"] == SHOWN].set_index("model")
    year = SHOWN[:4]
    table[f"peak of the bent drift {year}"] = shown["peak_ratio"].round(2)
    table[f"correlation {year}"] = shown["correlation"].round(2)
    return table.rename(
        columns=lambda name: f"error {name[:4]}" if name[:2] == "20" or name == SHOWN else name
    )


def main(folder: Path) -> None:
    """Write the tables and figures."""
    rows = events_table(read_frame(folder / "painter_rows.parquet"))
    rows.to_csv(DATA / "recorded.csv", index=False)
    changes_table(read_frame(folder / "painter_changes.parquet")).to_csv(
        DATA / "recorded_changes.csv"
    )
    for name, target in {SHOWN: SHOWN[:4], "changes": "changes"}.items():
        shutil.copyfile(folder / f"painter_{name}.svg", THEORY / f"recorded_{target}.svg")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
