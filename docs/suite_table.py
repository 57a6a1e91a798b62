"""Table of effects by suite of motions.

`python docs/suite_table.py RESULTS` stores the effects of a finished study with several suites,
such as `results/suites`, in `docs/data/suites.csv`; the first line of the file describes the study.
`docs/conf.py` makes a page of the site from this file.
"""

import sys
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.files.tables import read_frame, records_of
from skewbridge.files.text import write_text
from skewbridge.fragility.study_tables import ALL_SUITES, DEPENDS
from skewbridge.report.answer import change_name, effect_name
from skewbridge.study.folder import StudyFolder
from skewbridge.variant.random_properties import drawn_properties

ROOT: Final = Path(__file__).parents[1]
DATA: Final = Path("docs/data/suites.csv")
#: Demands and limit states of the table, as at the top of the report.
DEMANDS: Final = (
    *("column_drift_ratio", "column_shear_dcr", "unseating_m", "bearing_disp_m"),
    *("column_failure/any", "unseating/slight", "bearing/slight"),
)
_CHANGE: Final = ["bridge", "axis", "from_value", "to_value"]


def stored_page() -> str:
    """Return the Markdown page of the stored effects."""
    setting = (ROOT / DATA).read_text(encoding="utf-8").split("\n", 1)[0].removeprefix("# ")
    suites = pd.read_csv(ROOT / DATA, skiprows=1).fillna({"suite": "", "against": ""})
    return f"# Effects by suite of motions\n\n{setting}\n\n{table_text(suites)}\n"


def table_text(suites: pd.DataFrame) -> str:
    """Return Markdown tables per bridge and change; columns: each suite and all motions."""
    names = list(dict.fromkeys(suites.loc[suites["against"] == "", "suite"]))
    titles = ["all motions" if name == ALL_SUITES else name for name in names]
    head = ["change of", *titles, "suites that differ"]
    shown = suites[suites["demand"].isin(DEMANDS)]
    order = shown.assign(rank=shown["demand"].map(DEMANDS.index)).sort_values(
        ["bridge", "axis", "rank"], kind="stable"
    )
    lines: list[str] = []
    for (bridge, *change), group in order.groupby(_CHANGE, sort=False):
        lines += [f"## {bridge}: {change_name(*change)}", ""]
        lines += [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
        for demand, part in group.groupby("demand", sort=False):
            effects = {row["suite"]: row for row in records_of(part[part["against"] == ""])}
            pairs = [
                f"{each['suite']}/{each['against']} ({each['standard_errors']:.1f})"
                for each in records_of(part[part["verdict"] == DEPENDS])
            ]
            title = effect_name(str(demand))
            cells = [
                f"median of {title}" if "/" in str(demand) else title,
                *(_cell(effects[name]) if name in effects else "-" for name in names),
                ", ".join(pairs) or "none",
            ]
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines).rstrip()


def _cell(row: dict[str, Any]) -> str:
    """Return an effect and its interval in per cent, such as ``-3.2 (-4.3 to -2.1)``."""
    change, low, high = (100.0 * (row[name] - 1.0) for name in ("ratio", "ci_low", "ci_high"))
    return f"{change:+.1f} ({low:+.1f} to {high:+.1f})"


def setting_of(demands: pd.DataFrame, suites: pd.DataFrame) -> str:
    """Return a text that describes the study and the columns of the table."""
    counts = demands.groupby("suite", sort=False)["motion_id"].nunique()
    listed = ", ".join(f"{name} {count}" for name, count in counts.items())
    drawn = "drawn for each motion" if drawn_properties(map(str, demands)) else "not random"
    level = 100.0 * float(suites["level"].iloc[0])
    return (
        f"Change in %, with {level:g} % intervals, pooled over {demands['variant'].nunique()} "
        f"variants; motions: {listed}; properties of the bridge {drawn}. Last column: pairs of "
        "suites whose effects differ by more than two standard errors (number in brackets); one "
        "comparison in 20 does so by chance."
    )


def main(results: Path) -> None:
    """Store the effects of a study, with its description in the first line."""
    folder = StudyFolder(results)
    suites = read_frame(folder.fragility("suites"))
    numbers = suites.select_dtypes(include=[np.number]).columns
    suites = suites[suites["demand"].isin(DEMANDS)]
    kept = suites.assign(**{name: suites[name].map("{:.5g}".format) for name in numbers})
    setting = setting_of(read_frame(folder.demands), suites)
    write_text(ROOT / DATA, f"# {setting}\n{kept.to_csv(index=False)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
