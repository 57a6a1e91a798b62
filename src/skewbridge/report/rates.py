"""Annual rates: the sentence and table of the page, and the chart of what a skew needs."""

from collections.abc import Mapping
from contextlib import suppress
from math import radians
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.bridge_check import seat_demand_aashto_m, seat_demand_sdc_m
from skewbridge.bridge.library import load_structure
from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.fragility.decision import GAP, Decision
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.report.answer import change_name, effect_name, model_name
from skewbridge.report.appearance import STYLE, VARIANT_COLOURS, plain_log_ticks, shown_unit

_DASHES: Final = ((0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)), "-")


def rates_on_page(frames: Mapping[str, pd.DataFrame]) -> dict[str, Any] | None:
    """Return sentence and rows on annual rates; None for a study without a hazard curve."""
    effects = frames.get("rate_effects", pd.DataFrame())
    if effects.empty:
        return None
    pooled = effects[effects["scope"] == "pooled"]
    pooled = pooled.assign(state=pooled["component"] + "/" + pooled["limit_state"])
    # the most severe headline state, then that of the seat
    rated = [state for state in HEADLINE_STATES if (pooled["state"] == state).any()]
    states = [*rated[:1], *(state for state in rated[1:] if state.startswith("unseating"))]
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
        row = max(certain, key=lambda candidate: max(candidate["ratio"], 1.0 / candidate["ratio"]))
        sentence = (
            f"{change_name(row['axis'], row['from_value'], row['to_value'])} multiplies the annual "
            f"rate of {effect_name(row['state'])} by {row['ratio']:.2g} ({row['ci_low']:.2g} to "
            f"{row['ci_high']:.2g}) in {model_name(row['bridge'], row['abutment'])}."
        )
    return {"sentence": sentence, "rows": rows, "level": f"{100 * shown['level'].iloc[0]:g} %"}


def with_codes(decision: Decision, bridge: str) -> Decision:
    """Add the seat lengths of AASHTO and SDC; columns are left out if the bridge is not known."""
    table = decision.table
    with suppress(InputError):
        description, gap_m = load_structure(bridge).description, table[GAP] / 1000.0
        aashto = [seat_demand_aashto_m(description, radians(skew)) for skew in table["skew_deg"]]
        sdc = [seat_demand_sdc_m(description, demand_m) for demand_m in table["sdc_demand_m"]]
        seat_m = min(description.seats_m.values(), default=np.nan)
        table = table.assign(aashto_m=aashto + gap_m, sdc_m=sdc + gap_m, present_m=seat_m)
    return decision._replace(table=table)


@mpl.rc_context(STYLE)
def decision_figure(decision: Decision, title: str) -> Figure:
    """Draw needed seat lengths with the rules of codes, and rates of column failure, over skew."""
    unit, factor = shown_unit("mm")
    per_m, table = 1000.0 * factor, decision.table
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    seat_axes, rate_axes = figure.subplots(1, 2)
    end_gaps = sorted({table[GAP].min(), table[GAP].max()})
    for gap, colour in zip(end_gaps, VARIANT_COLOURS, strict=False):
        rows = table[table[GAP] == gap]
        for axes, name, scale in ((seat_axes, "seat_m", per_m), (rate_axes, "column_rate", 1.0)):
            if name in rows:
                low, middle, high = (scale * rows[f"{name}{end}"] for end in ("_low", "", "_high"))
                label = f"gap {factor * gap:.3g} {unit}, {100 * decision.level:g} % interval"
                axes.fill_between(rows["skew_deg"], low, high, color=colour, alpha=0.18, lw=0)
                axes.plot(rows["skew_deg"], middle, color=colour, lw=2.0, label=label)
    rows = table[table[GAP] == end_gaps[-1]]
    rules = {
        "hazus_m": "Hazus 6.1 factor on skew 0",
        "aashto_m": "AASHTO 4.7.4.4, 1.5 N",
        "sdc_m": "SDC 1.7, 7.8.3",
        "present_m": "seat of the bridge",
    }
    for (name, label), dashes in zip(rules.items(), _DASHES, strict=True):
        if name in rows:
            line = {"ls": dashes, "color": "0.25", "lw": 1.2, "label": label}
            seat_axes.plot(rows["skew_deg"], per_m * rows[name], **line)
    rate_axes.axhline(decision.target, color="#b3202c", lw=1.2, label="target rate")
    heads = f"Seat length, normal ({unit})", "Annual rate of column failure"
    for axes, heading in zip((seat_axes, rate_axes), heads, strict=True):
        axes.set(yscale="log", xlabel="Skew (deg)", ylabel=heading)
    plain_log_ticks(seat_axes.yaxis)
    handles = dict(zip(*seat_axes.get_legend_handles_labels()[::-1], strict=True))
    handles |= dict(zip(*rate_axes.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=3, fontsize=8)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure
