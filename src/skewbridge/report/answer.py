"""Sentences on the main results of a study: effects on capacities and demands, failures.

The page and the README print these sentences. Effects are read from `answer_table`, counts of runs
from `run_counts`.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.bridge.backfill import LARGEST_TESTED_SKEW_DEG
from skewbridge.bridge.frame import Structure
from skewbridge.bridge.library import load_structure
from skewbridge.demands.columns import choice_text, demands_for
from skewbridge.demands.validity import failed_modes, is_complete
from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, axis_names, models_of
from skewbridge.fragility.fits import ALL_EXCEED, NO_EXCEEDANCE
from skewbridge.fragility.limit_states import COLUMN_FAILURE, HEADLINE_STATES
from skewbridge.fragility.study_tables import ALL_SUITES, DEPENDS, LARGEST_ERRORS
from skewbridge.fragility.verdicts import (
    DETECTABLE,
    HIGHER,
    LOWER,
    MEDIAN_CAPACITY,
    NEGLIGIBLE,
    OK,
    UNDECIDED,
)
from skewbridge.motions.levels import FACTOR_LIMITS
from skewbridge.motions.p695 import REPLACED
from skewbridge.motions.read import is_doubt
from skewbridge.report import appearance
from skewbridge.report.appearance import (
    TEXTS,
    change_text,
    demand_name,
    groups_of,
    in_words,
    interval_text,
    margin_text,
    number,
    one_line,
    shear_model_name,
    templates,
    value_text,
    with_unit,
)
from skewbridge.statuses import COLLAPSE, FAILED
from skewbridge.units import split_unit
from skewbridge.variant.axes import axes_of, axis
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS
from skewbridge.variant.random_properties import DRAW_PREFIX, drawn_options, drawn_properties
from skewbridge.variant.variant import ABUTMENTS

_EFFECT: Final = (*BRIDGE_COLUMNS, "axis", "from_value", "to_value", "demand")
_COUNTS: Final = ("n_cells", "n_without_curve", "n_extrapolated")
#: Columns of `answer_table`. `claim` is the printed verdict, adjusted for the family of comparisons
#: (Holm). For a demand it is the weaker of this verdict and the verdict at the intensity `im`.
ANSWER_COLUMNS: Final = (
    *(*_EFFECT[:-1], "quantity", "demand", "status", "ratio", "ci_low", "ci_high", "level"),
    *("margin", "claim", "im", "from_demand", "to_demand", "first_im", "last_im", "seat_m"),
    *(*_COUNTS, "n_exceed", "n_runs", "largest_share", "largest_motion", "by_value"),
    *("sure_to", "sure_ratio", "sure_low", "sure_high", "measure"),
)
NOT_REACHED: Final = "not_reached"
#: Share of one motion in the variance of an effect above which the page warns.
LARGEST_SHARE: Final = 0.3
#: Limit states on the first screen and in the README.
LEADING_STATES: Final = (f"{COLUMN_FAILURE}/any", "joint_unseating/slight", "unseating/slight")
_STATES: Final = tuple(dict.fromkeys((*LEADING_STATES, *HEADLINE_STATES)))
#: Certainty of a claim in a few words.
CERTAINTY: Final = {
    LOWER: "certain",
    HIGHER: "certain",
    DETECTABLE: "direction certain, size uncertain",
    NEGLIGIBLE: "certainly small",
    UNDECIDED: "uncertain",
}
SHORT_CERTAINTY: Final = {claim: text.partition(",")[0] for claim, text in CERTAINTY.items()}


def model_name(bridge: object, abutment: object) -> str:
    """Return the names of a bridge and its abutment model as text."""
    return f"{bridge}, {str(abutment).replace('_', '-')}"


def short_names(table: pd.DataFrame) -> dict[tuple[str, str], str]:
    """Return the shortest distinct names of the (bridge, abutment model) pairs of a table."""
    models = dict.fromkeys(zip(table["bridge"], table["abutment"], strict=True))
    if table["abutment"].nunique() == 1:
        return {model: model[0] for model in models}
    if table["bridge"].nunique() == 1:
        return {model: model[1].replace("_", "-") for model in models}
    return {model: model_name(*model) for model in models}


def distinct_names(table: pd.DataFrame) -> dict[tuple[str, str], str]:
    """Return `short_names`; a single bridge and abutment model has an empty name."""
    names = short_names(table)
    return names if len(names) > 1 else dict.fromkeys(names, "")


def listed(words: Iterable[str]) -> str:
    """Return words joined to a list: ``a, b and c``."""
    *first, last = list(words)
    return f"{', '.join(first)} and {last}" if first else last


def texts_with_own(texts: Mapping[str, str], bridges: Sequence[Structure]) -> dict[str, str]:
    """Return the values of each axis as text, with skews and gaps that bridge files state."""
    stated_texts = dict(texts)
    for name, takes in (("skew_deg", "takes_skew"), ("gap_mm", "takes_gap")):
        own_values = [
            f"{value_text(axis(name), value)} at {end}"
            + (f" of {bridge.name}" if len(bridges) > 1 else "")
            for bridge in bridges
            for end, value in bridge.description.own_values(name).items()
        ]
        has_effect = not bridges or any(getattr(bridge.description, takes) for bridge in bridges)
        parts = [
            *([texts[name]] if has_effect else []),
            *([listed(own_values)] if own_values else []),
        ]
        stated_texts[name] = " but ".join(parts) or "without effect"
    return stated_texts


def number_word(number: int) -> str:
    """Return a number as text; numbers up to eight as a word."""
    words = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight")
    return words[number] if number < len(words) else f"{number}"


def counted(number: int, noun: str) -> str:
    """Return a number and its noun, in the plural unless the number is one: ``two spans``."""
    return f"{number_word(number)} {noun}{'' if number == 1 else 's'}"


def change_name(name: Any, low: Any, high: Any) -> str:
    """Return a change of an axis in words, such as ``Skew 0° to 60°``."""
    change_axis = axis(name)
    return f"{change_axis.label} {value_text(change_axis, low)} to {value_text(change_axis, high)}"


def change_of(row: Mapping[str, Any]) -> str:
    """Return the change of an axis in a row of effects in words."""
    return change_name(row["axis"], row["from_value"], row["to_value"])


def effect_name(demand: Any) -> str:
    """Return the name of a demand or limit state (``component/state``) in words, without unit."""
    if demand == f"{COLUMN_FAILURE}/any":
        return "column failure"
    if "/" in demand:
        component, state = in_words(demand).split("/")
        return f"{component} ({state})"
    label = demand_name(demand)
    return label[:1].lower() + label[1:]


# --- tables of the answer


def run_counts(demands: pd.DataFrame) -> pd.DataFrame:
    """Return counts of runs per bridge and abutment model (axis empty) and per value of each axis.

    Columns: bridge, abutment, axis, value, n_runs, n_failed (a column failed), n_shear, n_flexure,
    n_collapse, n_stopped (no result), n_bounds (demands are not peaks of the whole motion).
    """
    modes = failed_modes(demands)
    flags = {
        "n_runs": 1,
        "n_failed": modes != "",
        "n_shear": modes == "shear",
        "n_flexure": modes == "flexure",
        "n_collapse": demands["status"] == COLLAPSE,
        "n_stopped": demands["status"].isin(FAILED),
        "n_bounds": ~is_complete(demands),
    }
    names = list(flags)
    rows: list[dict[str, Any]] = []
    for model, runs in models_of(demands.assign(**flags)):
        rows.append({**model, "axis": "", "value": np.nan, **runs[names].sum()})
        for name in axis_names(runs):
            if runs[name].nunique() > 1:
                sums = records_of(runs.groupby(name)[names].sum().reset_index(names="value"))
                rows += [{**model, "axis": name, **row} for row in sums]
    return pd.DataFrame(rows).astype(dict.fromkeys(names, int))


def _further_steps(medians: pd.DataFrame, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return texts on an effect at values of other axes, and its widest change with a clear effect.

    The text ``by_value`` is empty if the effect depends on no other axis. If the change over the
    whole range is undecided, ``sure_..`` describe the change to the largest value of the axis at
    which the family-wise verdict is lower or higher.
    """
    keys = [*_EFFECT[:4], "demand"]
    is_same = (medians[keys] == [row[name] for name in keys]).all(axis=1)
    steps = medians[is_same & (medians["scope"] == "pooled") & (medians["status"] == OK)]
    largest_step: dict[str, Any] = {}
    if row["claim"] not in (LOWER, HIGHER, NEGLIGIBLE):
        certain = steps[steps["verdict_family"].isin((LOWER, HIGHER))]
        for step in records_of(certain.sort_values("to_value", key=abs).tail(1)):
            names = zip(("sure_to", "sure_ratio", "sure_low", "sure_high"),
                        ("to_value", "ratio", "ci_low", "ci_high"), strict=True)  # fmt: skip
            largest_step = {name: step[source] for name, source in names}
    texts: list[str] = []
    whole_range = steps[steps["to_value"] == row["to_value"]]
    for other_axis in whole_range.loc[whole_range["p_interaction"] < 0.05, "interaction"]:
        by_value = medians[is_same & (medians["scope"] == "by_value") & medians[other_axis].notna()]
        by_value = by_value[(by_value["to_value"] == row["to_value"]) & (by_value["status"] == OK)]
        texts += [
            f"{axis(other_axis).label.lower()} {value_text(axis(other_axis), effect[other_axis])}: "
            f"{change_text(effect)} ({interval_text(effect)})"
            for effect in records_of(by_value)
        ]
    return largest_step | {"by_value": "; ".join(texts)}


def _shown_states(curves: pd.DataFrame) -> list[str]:
    """Return the states of the answer: `_STATES`, or two others if ``curves`` have none of them.

    The others are the mildest estimated states of the first two components.
    """
    keys = curves["component"] + "/" + curves["limit_state"]
    if keys.isin(_STATES).any():
        return list(_STATES)
    rows = curves.assign(demand=keys, is_missing=curves["status"] != OK)
    states = rows.groupby(["component", "demand"], sort=False)["is_missing"].all().reset_index()
    states = states.sort_values("is_missing", kind="stable").drop_duplicates("component")
    return states["demand"].tolist()[:2]


def leading_states(table: pd.DataFrame) -> list[str]:
    """Return the `LEADING_STATES` of an answer, or all its states if it has none of them."""
    states = table.loc[table["quantity"] == MEDIAN_CAPACITY, "demand"].unique().tolist()
    return [state for state in states if state in LEADING_STATES] or states


def answer_table(
    *,
    medians: pd.DataFrame,
    effects: pd.DataFrame,
    intensities: pd.DataFrame,
    curves: pd.DataFrame,
    bridges: Sequence[str] = (),
) -> pd.DataFrame:
    """Return the pooled headline effects of each axis, for the change to its largest value.

    The columns are `ANSWER_COLUMNS`. For each bridge, abutment model and axis, the states of
    `_shown_states` in ``curves`` come first, then the headline demands. A state
    without a ratio has the most frequent status of its variants without an estimate, or
    `NOT_REACHED` if no run exceeds it. ``bridges`` are names or files of the study.
    """
    headline = demands_for("headline")
    pooled = effects[(effects["scope"] == "pooled") & effects["demand"].isin(headline)]
    pooled = _of_largest_step(pooled, _EFFECT[:3])
    by_intensity = dict(iter(intensities.groupby(list(_EFFECT))))
    effect_keys = pooled[list(_EFFECT)].itertuples(index=False, name=None)
    demands = pd.DataFrame(map(_demand_row, records_of(pooled), map(by_intensity.get, effect_keys)))

    states = curves.assign(demand=curves["component"] + "/" + curves["limit_state"])
    states = states.drop_duplicates(["variant", "demand"])  # the first method: cloud

    def reason(statuses: "pd.Series[str]") -> str:
        return next(iter(statuses[statuses != OK].mode()), "")

    states = states.groupby([*BRIDGE_COLUMNS, "demand"], as_index=False).agg(
        n_exceed=("n_exceed", "sum"), n_runs=("n_runs", "sum"), missing=("status", reason)
    )
    changes = pooled[list(_EFFECT[:-1])].drop_duplicates()
    shown_states = _shown_states(curves)
    capacities = changes.merge(states[states["demand"].isin(shown_states)])
    pooled_medians = medians[medians["scope"] == "pooled"]
    capacities = capacities.merge(pooled_medians, how="left", on=list(_EFFECT))
    never_exceeded = (capacities["missing"] == NO_EXCEEDANCE) & (capacities["n_exceed"] == 0)
    missing = capacities["missing"].mask(never_exceeded, NOT_REACHED)
    own_status = capacities["status"].fillna("too_few_motions")  # a ratio needs five
    capacities = capacities.assign(
        quantity=MEDIAN_CAPACITY,
        status=own_status.where((own_status == OK) | (missing == ""), missing),
        claim=capacities["verdict_family"],
        from_demand=capacities["from_mean"],
        to_demand=capacities["from_mean"] * capacities["ratio"],
    )
    steps = [_further_steps(medians, row) for row in records_of(capacities)]
    capacities = capacities.join(pd.DataFrame(steps, index=capacities.index))

    table = pd.concat([capacities, demands]).reindex(columns=list(ANSWER_COLUMNS))
    order = {"axis": [varied.name for varied in axes_of(table["axis"])]}
    order["demand"] = [*shown_states, *headline]
    ranks = {f"_{name}": table[name].map(values.index) for name, values in order.items()}
    table = table.assign(**ranks).sort_values([*BRIDGE_COLUMNS, "_axis", "from_value", "_demand"])
    seats_m, files = dict[str, float](), {Path(name).stem: name for name in bridges}
    for name in map(str, set(table["bridge"])):
        with suppress(InputError):  # the file of the bridge cannot be read
            description = load_structure(files.get(name, name)).description
            seats_m[name] = min(description.end_seats_m.values(), default=np.nan)
    table["seat_m"] = table["bridge"].map(seats_m).where(table["demand"] == "unseating_m")
    numbers = ["seat_m", *_COUNTS]
    table[numbers] = table[numbers].apply(pd.to_numeric, errors="coerce").astype(float)
    return table.assign(measure=curves["im"].iloc[0])[list(ANSWER_COLUMNS)].reset_index(drop=True)


def _demand_row(effect: dict[str, Any], rows: pd.DataFrame | None) -> dict[str, Any]:
    """Return a pooled effect on a demand with its values at one intensity.

    ``rows`` has the effect at each intensity. The values are at the reference intensity of the
    bridge, or else at the middle one of ``rows``.
    """
    with_ratio = pd.DataFrame() if rows is None else rows[rows["ratio"].notna()].sort_values("im")
    if with_ratio.empty:
        return effect | {"claim": effect["verdict_family"]}
    at_reference = with_ratio[with_ratio["at_reference"].astype(bool)]
    at_im = with_ratio.iloc[len(with_ratio) // 2] if at_reference.empty else at_reference.iloc[0]
    columns = ("im", "ratio", "ci_low", "ci_high", "from_demand", "to_demand")
    im_range = {"first_im": with_ratio["im"].iloc[0], "last_im": with_ratio["im"].iloc[-1]}
    claim, claims = at_im["verdict"], {effect["verdict_family"], at_im["verdict"]}
    if len(claims) > 1:  # keep the weaker of the two
        same_sign = (at_im["ratio"] < 1.0) == (effect["direction"] < 0)
        claim = DETECTABLE if claims <= {LOWER, HIGHER, DETECTABLE} and same_sign else UNDECIDED
    return effect | {name: at_im[name] for name in columns} | im_range | {"claim": claim}


def _of_largest_step(table: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return the rows of each group with the largest |to_value|, the positive one of two."""
    size = table["to_value"].abs() + 1e-9 * (table["to_value"] > 0.0)
    return table[size == size.groupby([table[name] for name in keys]).transform("max")]


# --- sentences


_TEMPLATES: Final = templates(vars(appearance), globals())


def sentence(name: str, **values: Any) -> str:
    """Return a sentence of `captions.yaml`, filled in with values."""
    return one_line(_TEMPLATES, TEXTS["sentences"][name], **values)


def no_ratio_text(row: Mapping[str, Any]) -> str:
    """Return why a state has no ratio of medians, and how many runs exceed the state."""
    if row["status"] == NOT_REACHED:
        return "no run reaches it"
    one_outcome = row["status"] in (NO_EXCEEDANCE, ALL_EXCEED) and row["n_exceed"] < row["n_runs"]
    variants_text = " in some variants" if one_outcome else ""
    counts = f"{row['n_exceed']:.0f} of {row['n_runs']:.0f} runs exceed it"
    return f"{in_words(row['status'])}{variants_text}, {counts}"


def extent_of_data(row: Mapping[str, Any]) -> str:
    """Return a note if medians of a ratio are extrapolated or have no curve; otherwise ``""``."""
    n_pairs, missing, n_extrapolated = (row[name] for name in _COUNTS)
    medians = 2 if pd.isna(n_pairs) else 2 * int(n_pairs)  # a single pair has no such number
    if n_extrapolated > 0:
        return "extrapolated" if n_extrapolated == medians else "partly extrapolated"
    return f"from a model: {missing:.0f} of {medians} variants lack a curve" if missing > 0 else ""


def effect_notes(table: pd.DataFrame) -> list[str]:
    """Return sentences on effects dominated by one motion or dependent on another axis."""
    notes, names = list[str](), short_names(table)
    leading = table[table["demand"].isin(leading_states(table)) & (table["status"] == OK)]
    for (*model, state), rows in groups_of(leading, [*BRIDGE_COLUMNS, "demand"]):
        one_motion = [
            f"{change_of(row)} {row['largest_motion']} ({100 * row['largest_share']:.0f} %)"
            for row in records_of(rows[rows["largest_share"] > LARGEST_SHARE])
        ]
        by_value = records_of(rows[rows["by_value"].fillna("") != ""])
        if one_motion or by_value:
            texts: dict[str, Any] = {"one_motion": one_motion, "by_value": by_value}
            effect = f"{names[model[0], model[1]]}, {effect_name(state)}"
            notes.append(sentence("details", effect=effect, **texts))
    return notes


def headline(table: pd.DataFrame) -> list[str]:
    """Return one sentence per axis on its effects, certain and large ones first.

    A sentence names the change of each leading median capacity (g) and the largest certain change
    of a displacement, for the bridge with the largest effect. The last sentence lists the effects
    that are not decided.
    """
    if table.empty:
        return ["No comparison is possible: no two variants differ in one axis only."]
    leading, names = leading_states(table), distinct_names(table)
    capacities = table[table["quantity"] == MEDIAN_CAPACITY]
    estimated = capacities[capacities["status"] == OK]
    sentences = list[tuple[tuple[int, float], str]]()
    open_effects = list[str]()
    for (name, *_), change in estimated.groupby(["axis", "from_value", "to_value"], sort=False):
        demands = table[(table["axis"] == name) & (table["quantity"] != MEDIAN_CAPACITY)]
        sentences += _axis_sentence(change, demands, names)
        undecided = change[(change["claim"] == UNDECIDED) & change["demand"].isin(leading)]
        for (state,), rows in groups_of(undecided, ["demand"]):
            effects = ((names[row["bridge"], row["abutment"]], row) for row in records_of(rows))
            texts = (f"{n} {change_text(row)}, {interval_text(row)}".strip() for n, row in effects)
            text = f"{axis(str(name)).title} on {effect_name(state)} ({'; '.join(texts)})"
            open_effects.append(text)
    texts = [text for _, text in sorted(sentences)]
    if open_effects:
        texts.append(f"Not decided with these motions: {listed(open_effects)}.")
    if texts:
        return texts
    models = short_names(table)
    states = capacities[capacities["demand"].isin(leading) & (capacities["status"] != OK)]
    reasons = [
        f"{models[row['bridge'], row['abutment']]}, {effect_name(row['demand'])}: "
        f"{no_ratio_text(row)}"
        for row in records_of(states.drop_duplicates([*BRIDGE_COLUMNS, "demand"]))
    ]
    return [f"{'; '.join(['No median capacity of a headline state can be compared', *reasons])}."]


def _axis_sentence(
    table: pd.DataFrame, demands: pd.DataFrame, names: Mapping[tuple[str, str], str]
) -> list[tuple[tuple[int, float], str]]:
    """Return the sentence on an axis with its sorting key; an empty list if nothing is decided."""
    change = change_name(*table[["axis", "from_value", "to_value"]].iloc[0])
    by_verb, sizes, ranks = dict[str, list[str]](), list[float](), list[int]()
    decided = table[table["claim"].isin((LOWER, HIGHER, DETECTABLE)) | table["sure_ratio"].notna()]
    leading = decided[decided["demand"].isin(LEADING_STATES)]
    for _, rows in groups_of(leading if len(leading) else decided, ["demand"]):
        effects = records_of(rows)
        certain = [effect for effect in effects if effect["claim"] in (LOWER, HIGHER)]
        row = max(certain or effects, key=lambda effect: abs(np.log(effect["ratio"])))
        verb = "lowers" if row["ratio"] < 1.0 else "raises"
        sure = {"ratio": row["sure_ratio"], "ci_low": row["sure_low"], "ci_high": row["sure_high"]}
        other_models = [
            f"{names[effect['bridge'], effect['abutment']]}: {change_text(effect)}"
            + f", {SHORT_CERTAINTY[effect['claim']]}" * (effect["claim"] != row["claim"])
            for effect in effects
            if effect is not row and effect["claim"] in (LOWER, HIGHER, DETECTABLE)
            if (effect["ratio"] < 1.0) == (row["ratio"] < 1.0)
        ]
        clause = sentence(
            "capacity",
            row=row,
            model=names[row["bridge"], row["abutment"]],
            certainty=SHORT_CERTAINTY[row["claim"]],
            sure=sure if np.isfinite(row["sure_ratio"]) else {},
            other_models=other_models if len(other_models) <= 2 else [],
            extent=extent_of_data(row),
        )
        by_verb.setdefault(f"{verb} the median capacity", []).append(clause)
        sizes.append(abs(float(np.log(row["ratio"]))))
        ranks.append(0 if row["claim"] in (LOWER, HIGHER) or np.isfinite(row["sure_ratio"]) else 1)
    clauses = [f"{verb} {' and '.join(texts)}" for verb, texts in by_verb.items()]
    if clause := displacement_clause(demands, names):
        clauses.append(clause)
    leading = table[table["demand"].isin(LEADING_STATES)]
    shown_effects = leading if len(leading) else table
    if not sizes and set(shown_effects["claim"]) == {NEGLIGIBLE}:
        states = listed(map(effect_name, shown_effects["demand"].unique()))
        largest = (shown_effects["to_demand"] - shown_effects["from_demand"]).abs().max()
        largest_text = with_unit(f"{largest:.2g}", table["measure"].iloc[0])
        limit = f"{margin_text(table.iloc[0])} (most: {largest_text})"
        clauses.insert(0, f"changes no median capacity for {states} by more than {limit}")
    if not clauses:
        return []
    return [((min(ranks, default=2), -max(sizes, default=0.0)), f"{change} {listed(clauses)}.")]


def displacement_clause(table: pd.DataFrame, names: Mapping[tuple[str, str], str]) -> str:
    """Return a clause on the largest certain change of a displacement; empty if none is certain."""
    numbers = table[["im", "ratio", "from_demand", "to_demand"]].astype(float)
    is_clear = table["claim"].isin((LOWER, HIGHER)) & np.isfinite(numbers).all(axis=1)
    certain = table[is_clear & table["demand"].str.endswith("_m")]
    if certain.empty:
        return ""
    row = records_of(certain)[int((certain["to_demand"] - certain["from_demand"]).abs().argmax())]
    return sentence("displacement", row=row, model=names[row["bridge"], row["abutment"]])


def failure_sentences(counts: pd.DataFrame, *, has_capacities: bool = True) -> tuple[str, str]:
    """Return two texts: runs with a failed column, and runs that collapsed or ended early.

    Without capacities of columns in the demands, no failure can be counted.
    """
    per_model, names = counts[counts["axis"] == ""], short_names(counts)
    totals = per_model.filter(regex="^n_").sum().astype(int)
    models = [
        f"{row['n_failed']} of {row['n_runs']} of {names[row['bridge'], row['abutment']]}"
        for row in records_of(per_model)
    ]
    modes = [
        f"{totals[f'n_{mode}']} in {mode}"
        for mode in ("shear", "flexure")
        if totals[f"n_{mode}"] > 0
    ]
    failures = {"total": totals, "models": models, "kinds": modes, "has_capacities": has_capacities}
    return sentence("failures", **failures), sentence("early_ends", total=totals)


def shear_model_sentence(demands: pd.DataFrame) -> str:
    """Return the number of runs with a column at its shear strength, by strength model and bridge.

    The ratios are peaks of whole motions, also after a column failure. The numbers are lower bounds
    if some runs ended early. The text is empty if the demands do not include the ratios.
    """
    ratios = [demand for demand in SHEAR_MODEL_DEMANDS.values() if demand in demands]
    if not ratios:
        return ""
    names, texts = short_names(demands), list[str]()
    for model, runs in groups_of(demands, BRIDGE_COLUMNS):
        counts = {ratio: (runs[ratio] >= 1.0).sum() for ratio in ratios}
        by_model = [f"{count} by {shear_model_name(ratio)}" for ratio, count in counts.items()]
        text = "; ".join(by_model) if any(counts.values()) else "none by any model"
        texts.append(f"{names[model]} ({len(runs)} runs): {text}")
    bounds = " (lower bounds: some runs ended early)"
    note = bounds if demands["status"].isin((COLLAPSE, *FAILED)).any() else ""
    return f"Runs with a column at its shear strength{note}. {'. '.join(texts)}."


def motions_sentence(suite: pd.DataFrame, table: pd.DataFrame) -> str:
    """Return a sentence on the kind, scenario and intensity range of the motions."""
    sources = suite.get("source", pd.Series(dtype=str)).astype(str)
    synthetic = len(sources) > 0 and sources.str.contains("synthetic|simulated", case=False).all()
    recorded = len(sources) > 0 and sources.str.startswith("recorded").all()
    values: dict[str, Any] = {"suite": suite, "synthetic": synthetic, "recorded": recorded}
    events = suite.get("event", pd.Series([""]))
    values["events"] = not events.str.match("$|DDK18").any()  # each is a recorded earthquake
    values["replaced"] = f", {REPLACED}," if sources.str.contains(REPLACED).any() else ""
    if {"magnitude", "distance_km"} <= set(suite.columns) and suite["magnitude"].notna().any():
        values["magnitude"], values["distance"] = (
            " to ".join(dict.fromkeys(map(number, (suite[name].min(), suite[name].max()))))
            for name in ("magnitude", "distance_km")
        )
    im_range = {"first_im": table["first_im"].min(), "last_im": table["last_im"].max()}
    values["measure"] = next(iter(table.get("measure", [])), "")
    return sentence("motions", **{"magnitude": "", **values, **im_range})


def motion_doubts(suite: pd.DataFrame, demands: pd.DataFrame) -> str:
    """Return the numbers of motions with an incredible scale factor or a doubt of their reader."""
    far = demands[~demands["scale"].between(*FACTOR_LIMITS)]
    doubted = suite[suite["messages"].map(is_doubt)]
    n_far, n_doubted = (rows["motion_id"].nunique() for rows in (far, doubted))
    return sentence("motion_doubts", n_far=n_far, n_doubted=n_doubted, limits=FACTOR_LIMITS)


#: Abutment models of this package with backfill.
BACKFILLED: Final = [name for name, traits in ABUTMENTS.items() if traits.backfill != "none"]


def untested_skew_sentence(skews_deg: Iterable[float]) -> str:
    """Return a sentence if the largest skew exceeds that of all wall tests; otherwise ``""``."""
    largest, tested = max(map(abs, skews_deg), default=0.0), LARGEST_TESTED_SKEW_DEG
    text = f"No test of backfill has a skew above {tested:g}°: the passive strength at {largest:g}°"
    return f"{text} is extrapolated." if largest > tested else ""


def suites_summary(suites: pd.DataFrame, table: pd.DataFrame) -> tuple[str, str]:
    """Return two texts on whether the headline effects depend on the suite of motions.

    The first is a sentence for the headline; it is empty if no more suites differ than expected by
    chance. The second states the largest difference and its interval; it is empty for one suite.
    """
    if suites.empty:
        return "", ""
    keys = [*_EFFECT, "quantity"]
    common = suites.merge(table.loc[table["status"] == OK, keys], on=keys)
    compared = common[common["against"] != ""]
    if compared.empty:
        return "", ""
    differing = compared[compared["verdict"] == DEPENDS]
    effects = common[(common["against"] == "") & (common["suite"] != ALL_SUITES)]
    motions = effects.groupby("suite", sort=False)["n_motions"].max()
    largest = records_of(compared.sort_values("standard_errors", ascending=False).head(1))[0]
    same_effect = (effects[list(_EFFECT)] == [largest[name] for name in _EFFECT]).all(axis=1)
    by_suite = {effect["suite"]: effect for effect in records_of(effects[same_effect])}
    text = sentence(
        "suites",
        motions=[f"{name} ({count})" for name, count in motions.items()],
        differing=len(differing),
        compared=len(compared),
        by_chance=0.05 * len(compared),
        standard_errors=LARGEST_ERRORS,
        largest=largest,
        model=short_names(compared)[largest["bridge"], largest["abutment"]],
        effects=by_suite,
    )
    if len(differing) <= 0.05 * len(compared):  # no more than expected by chance
        return "", text
    axes = listed(dict.fromkeys(axis(str(name)).title for name in differing["axis"]))
    return f"The effect of {axes} {DEPENDS}.", text


def alternative_rows(table: pd.DataFrame) -> tuple[list[str], list[dict[str, str]]]:
    """Return sentences and a table on options drawn at random, for the largest step of each axis.

    An option certainly moves an effect if its p-value, adjusted for all options of the effect, is
    below 1 minus the level of the intervals. The table has a column per value of an option.
    """
    table = _of_largest_step(table, [*BRIDGE_COLUMNS, "axis"])
    if table.empty:
        return [], []
    names, rows, certain = short_names(table), list[dict[str, str]](), list[str]()
    for key, effect_rows in groups_of(table, _EFFECT):
        effect = f"{change_name(*key[2:5])} on {effect_name(key[5])}, {names[key[:2]]}"
        changes: dict[str, str] = {}
        for (option,), of_option in groups_of(effect_rows, ["option"]):
            at_values = records_of(of_option.assign(ratio=of_option["effect"]))
            choices = [
                f"{option_text(option)} {choice_text(option, r['value'])}" for r in at_values
            ]
            texts = dict(zip(choices, map(change_text, at_values), strict=True))
            changes |= texts
            if of_option["p"].min() < 1.0 - of_option["level"].iloc[0]:
                certain.append(f"{effect}: {listed(f'{b} with {a}' for a, b in texts.items())}.")
        rows.append({"effect": effect, **changes})
    options = listed(option_text(option) for option in table["option"].unique())
    shares = 100.0 * (1.0 - np.sqrt(1.0 - table["share"]))
    first_sentence = sentence("alternatives", options=options, shares=shares, certain=certain)
    return [first_sentence, *certain], records_of(pd.DataFrame(rows).fillna("–"))


def option_text(option: str) -> str:
    """Return the name of a modelling option in words, without its unit."""
    return in_words(split_unit(option)[0])


def ignored_by_all(bridges: Sequence[Structure]) -> frozenset[str]:
    """Return the modelling options that all bridges of a study ignore."""
    return (
        frozenset.intersection(*(bridge.ignored for bridge in bridges)) if bridges else frozenset()
    )


def properties_sentence(demands: pd.DataFrame, bridges: Sequence[Structure] = ()) -> str:
    """Return a sentence that lists the random properties that act, if there are any."""
    ignored = {f"{DRAW_PREFIX}{name}" for name in ignored_by_all(bridges)}
    names = [name for name in map(str, demands) if name not in ignored]
    options = [option_text(option) for option in drawn_options(names)]
    return sentence("properties", drawn=drawn_properties(names), options=options)


def rates_on_page(frames: Mapping[str, pd.DataFrame]) -> dict[str, Any] | None:
    """Return sentence and rows on annual rates; None for a study without a hazard curve."""
    effects = frames.get("rate_effects", pd.DataFrame(columns=["scope", "status"]))
    pooled = effects[(effects["scope"] == "pooled") & (effects["status"] == OK)]
    if pooled.empty:
        return None
    pooled = pooled.assign(state=pooled["component"] + "/" + pooled["limit_state"])
    # the most severe headline state, then that of the seat
    available = [state for state in HEADLINE_STATES if (pooled["state"] == state).any()]
    states = [*available[:1], *(state for state in available[1:] if state.startswith("unseating"))]
    printed = pooled[pooled["state"].isin(states or pooled["state"].iloc[:1])]
    printed = _of_largest_step(printed, ["bridge", "abutment", "axis", "state"])
    # a state that no run or every run of a variant exceeds has no rate there, and thus fewer pairs
    most_pairs = printed.groupby([*BRIDGE_COLUMNS, "axis", "to_value"])["n_cells"].transform("max")
    medians = frames["medians"].query("scope == 'pooled'").rename(columns={"demand": "state"})
    names = [*BRIDGE_COLUMNS, "axis", "from_value", "to_value", "state"]
    joined = medians[[*names, "n_without_curve", "verdict_family"]]
    printed = printed.merge(joined, how="left", on=names)
    notes = [
        f"{row['n_cells']:.0f} of {n:.0f} pairs"
        if row["n_cells"] < n
        else extent_of_data(row | {"n_extrapolated": 0})
        for n, row in zip(most_pairs, records_of(printed), strict=True)
    ]
    printed = printed.assign(pairs=[f" ({note})" if note else "" for note in notes])
    # certain as the change of the median, jointly with the other headline verdicts
    claimed = printed["verdict_family"].isin((LOWER, HIGHER, DETECTABLE))
    certain = records_of(printed[claimed & (printed["direction"] != 0)])
    certain.sort(key=lambda row: (row["pairs"] != "", -max(row["ratio"], 1.0 / row["ratio"])))
    return {
        "sentence": sentence("rates", largest=certain[:1]),
        "rows": records_of(printed),
        "level": f"{100 * printed['level'].iloc[0]:g} %",
    }
