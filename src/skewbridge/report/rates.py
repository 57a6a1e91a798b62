"""Annual rates on the first screen of the page: one sentence and a table of their changes."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from skewbridge.files.tables import records_of
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.report.answer import change_name, effect_name, model_name


def rates_on_page(frames: Mapping[str, pd.DataFrame]) -> dict[str, Any] | None:
    """Return sentence and rows on annual rates; None for a study without a hazard curve."""
    effects = frames.get("rate_effects", pd.DataFrame())
    if effects.empty:
        return None
    pooled = effects[effects["scope"] == "pooled"]
    pooled = pooled.assign(state=pooled["component"] + "/" + pooled["limit_state"])
    # the most severe headline state, then that of the seat
    found = [state for state in HEADLINE_STATES if (pooled["state"] == state).any()]
    states = [*found[:1], *(state for state in found[1:] if state.startswith("unseating"))]
    shown = pooled[pooled["state"].isin(states or pooled["state"].iloc[:1])]
    last = shown.groupby(["bridge", "abutment", "axis", "state"], sort=False)["to_value"]
    shown = shown[shown["to_value"] == last.transform("max")]
    rows = [
        {
            "change": change_name(row["axis"], row["from_value"], row["to_value"]),
            "model": model_name(row["bridge"], row["abutment"]),
            "state": effect_name(row["state"]),
            "rate per year": f"{row['from_rate']:.2g} → {row['to_rate']:.2g}",
            "factor": f"{row['ratio']:.2f} ({row['ci_low']:.2f} to {row['ci_high']:.2f})",
        }
        for row in records_of(shown)
    ]
    certain = [row for row in records_of(shown) if row["direction"]]
    sentence = "No axis changes these annual rates for certain."
    if certain:
        row = max(certain, key=lambda each: max(each["ratio"], 1.0 / each["ratio"]))
        sentence = (
            f"{change_name(row['axis'], row['from_value'], row['to_value'])} multiplies the annual "
            f"rate of {effect_name(row['state'])} by {row['ratio']:.2g} ({row['ci_low']:.2g} to "
            f"{row['ci_high']:.2g}) in {model_name(row['bridge'], row['abutment'])}."
        )
    return {"sentence": sentence, "rows": rows, "level": f"{100 * shown['level'].iloc[0]:g} %"}
