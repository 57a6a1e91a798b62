"""Tables and figure for the pages on published curves and published effects of skew.

`python docs/published_tables.py FOLDER` writes `docs/data/published_*.csv` and
`docs/theory/published_medians.svg` from the files of
`skewbridge verify published published-skew --out FOLDER`.
"""

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.files.tables import read_frame, records_of
from skewbridge.fragility.limit_states import hazus_factor
from skewbridge.verification.studies.published import CHOICES, CHOSEN, NONE

ROOT: Final = Path(__file__).parents[1]
DATA: Final = ROOT / "docs" / "data"
FIGURE: Final = ROOT / "docs" / "theory" / "published_medians.svg"
#: Short name of each change, keyed by the start of its name in the study.
SHORT: Final = {
    "capacity: joint opening": "capacity of era 2",
    "capacity: bearing": "capacity 3 in",
    "demand: any move": "any move",
    "demand: curvature": "first yield",
    "demand: up to": "up to the failure of a column",
    "bridge: bridge_b": "bridge B",
    "gap: 51 mm": "gap 51 mm",
    "keys: do not break": "keys that do not break",
}
#: Limit states of the table of medians; Hazus does not scale slight damage.
STATES: Final = (
    "unseating/slight",
    "unseating/moderate",
    "column_curvature/moderate",
    "bearing/moderate",
    "abutment_transverse/moderate",
)
NAMES: Final = {
    "column_drift_ratio": "column drift",
    "column_shear_dcr": "column shear over capacity",
    "deck_disp_m": "deck displacement",
    "deck_rotation_rad": "deck rotation",
    "unseating_m": "unseating",
    "abutment_transverse_m": "abutment transverse",
}


def ratios_table(ratios: pd.DataFrame, explained: pd.DataFrame) -> pd.DataFrame:
    """Return medians, ratios and the change with the largest effect, one row per state."""
    keys = ["era", "component", "state"]
    changes = explained.set_index(keys)
    rows: list[dict[str, Any]] = []
    for row in records_of(ratios[(ratios["change"] == NONE.name) & ratios["ratio"].notna()]):
        change = changes.loc[tuple(row[key] for key in keys)]
        text = ""
        if change["change"] != NONE.name:
            short = next(
                name for start, name in SHORT.items() if change["change"].startswith(start)
            )
            text = f"{short}: {change['changed_ratio']:.2f}"
        text += "" if change["is_explained"] else ", not explained"
        rows.append(
            {
                "era": row["era"],
                "component": f"{row['component'].replace('_', ' ')}, {row['state']}",
                "published": f"{row['median_g']:.2f} ({row['dispersion']:.2f})",
                "ours": f"{row['theta']:.2f} ({row['beta']:.2f})",
                "ratio": interval(row),
                "change: ratio with it": text.removeprefix(", "),
            }
        )
    return pd.DataFrame(rows)


def medians_table(medians: pd.DataFrame) -> pd.DataFrame:
    """Return median ratios to skew 0 and the Hazus factors, one row per limit state."""
    skews = sorted({*medians["skew_deg"]})
    plain = medians[medians["choice"] == "none"]
    table = by_bridge(
        plain, {state: state.replace("_", " ").replace("/", ", ") for state in STATES}
    )
    factors = {
        state: ["1" if state.endswith("/slight") else f"{hazus_factor(skew):.2f}" for skew in skews]
        for state in STATES
    }
    title = "Hazus " + ", ".join(f"{skew:g}" for skew in skews)
    table.insert(0, title, [", ".join(factors[state]) for state in STATES])
    return table.rename_axis("limit state").reset_index()


def demands_table(demands: pd.DataFrame) -> pd.DataFrame:
    """Return the ratios of demands to those at skew 0, one row per demand."""
    return (
        by_bridge(demands[demands["choice"] == "none"], NAMES).rename_axis("demand").reset_index()
    )


def choices_table(demands: pd.DataFrame) -> pd.DataFrame:
    """Return demand ratios at the largest skew, one row per demand, one column per choice."""
    largest = demands[
        (demands["bridge"] == CHOSEN) & (demands["skew_deg"] == max(demands["skew_deg"]))
    ]
    table = pd.DataFrame(
        {choice: cells(largest[largest["choice"] == choice], NAMES) for choice in CHOICES}
    )
    return table.rename_axis("demand").reset_index()


def by_bridge(table: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return ratios with intervals: one row per demand name, one column per bridge and skew."""
    groups = table.groupby(["bridge", "skew_deg"])
    return pd.DataFrame(
        {
            f"{str(bridge).removeprefix('bridge_').upper()} {skew:g}": cells(part, names)
            for (bridge, skew), part in groups
        }
    )


def cells(part: pd.DataFrame, names: Mapping[str, str]) -> dict[str, str]:
    """Return the ratio and interval of each demand as text, keyed by demand name."""
    rows = {row["demand"]: row for row in records_of(part)}
    return {name: interval(rows[demand]) for demand, name in names.items()}


def interval(row: Mapping[str, Any]) -> str:
    """Return a ratio with its interval, such as ``1.11 (0.95 to 1.34)``."""
    return f"{row['ratio']:.2f} ({row['ratio_low']:.2f} to {row['ratio_high']:.2f})"


def main(folder: Path) -> None:
    """Write the tables and copy the figure."""
    skew_demands = read_frame(folder / "published-skew_demands.parquet")
    tables = {
        "published_ratios": ratios_table(
            read_frame(folder / "published_ratios.parquet"),
            read_frame(folder / "published_explained.parquet"),
        ),
        "published_skew_medians": medians_table(
            read_frame(folder / "published-skew_medians.parquet")
        ),
        "published_skew_demands": demands_table(skew_demands),
        "published_skew_choices": choices_table(skew_demands),
    }
    for name, table in tables.items():
        table.to_csv(DATA / f"{name}.csv", index=False)
    shutil.copy(folder / "published_medians.svg", FIGURE)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
