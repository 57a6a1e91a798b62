"""Effects of modelling choices (`CHOICES`), compared with effects of friction, gap and skew.

Each choice is an option that another engineer could set differently. It is changed by itself under
a few motions, and the demands are compared with the configured model motion by motion. The axes of
the grid are compared in the same way, from their lowest to their highest value.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np
import pandas as pd
from scipy.stats import t as student

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacities
from skewbridge.bridge.frame import Description
from skewbridge.bridge.library import load_structure, without_effect
from skewbridge.demands.columns import choice_text, demands_for
from skewbridge.demands.validity import BEYOND_MODEL
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.files.text import read_yaml
from skewbridge.statuses import OK
from skewbridge.study.analyses import StudySetup, run_in_journal, sampled
from skewbridge.study.folder import COLUMNS_FILE
from skewbridge.study.task import Task, run_key
from skewbridge.variant.options import HingeRule
from skewbridge.variant.variant import ABUTMENTS, Variant

type Value = bool | float | str | tuple[str | float, ...]
#: Labels (kind, name, from_value, to_value) and two analyses that differ in one modelling option
#: (kind ``choice``) or one axis of the grid (kind ``axis``).
type TaskPair = tuple[dict[str, str], Task, Task]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One option and the values to try, see modelling_choices.yaml."""

    key: str
    label: str
    values: tuple[Value, ...]
    source: str = ""
    section: str = "model"
    acts_on: tuple[str, ...] = ()
    needs: Mapping[str, Value] = field(default_factory=dict[str, Value])

    def configured_in(self, task: Task) -> Value:
        """Return the value of the option in a task, without the random factor of the motion."""
        settings, options = _effective(task)
        value: Any = getattr(settings if self.section == "analysis" else options, self.key)
        if self.key in task.draw:
            return round(value / task.draw[self.key], 9)
        return _WHEN_NULL[self.key](task) if value is None else value

    def set_in(self, task: Task, value: Value) -> Task:
        """Return a task with a value of the option, times the random factor of the motion."""
        if self.key in task.draw and isinstance(value, float):
            value *= task.draw[self.key]
        if self.section == "analysis":
            return replace(task, settings=replace(task.settings, **{self.key: value}))
        return replace(task, options=replace(task.options, **{self.key: value}))

    def alternatives(self, task: Task) -> list[Value]:
        """Return the values of the option that change an analysis.

        The list is empty if the option does not act on the variant, if `needs` is not met, or if
        the scheme sets the option.
        """
        if self.key in without_effect(task.variant.bridge):
            return []
        pair, configured = _effective(task), self.configured_in(task)
        acts = all(_ACTS_ON[name](task) for name in self.acts_on)
        if not acts or any(getattr(pair[1], key) != wanted for key, wanted in self.needs.items()):
            return []
        other_values = [value for value in self.values if value != configured]
        return [value for value in other_values if _effective(self.set_in(task, value)) != pair]


def _effective(task: Task) -> tuple[object, object]:
    return task.settings, task.settings.model_options(task.options)


def _bridge(task: Task) -> Description:
    return load_structure(task.variant.bridge).description


def _has_limited_hinge(task: Task) -> bool:
    rules, bridge = get_args(HingeRule.__value__), load_bridge(task.variant.bridge)
    bents = zip(*(bent_capacities(bridge, rule) for rule in rules), strict=True)
    return any(unlimited.hinge_length_m != limited.hinge_length_m for unlimited, limited in bents)


#: Named conditions on an analysis, see modelling_choices.yaml.
_ACTS_ON: Final[Mapping[str, Callable[[Task], bool]]] = {
    "keys": lambda task: task.variant.traits.has_pads,
    "contacts": lambda task: task.variant.traits.has_contacts,
    "friction": lambda task: task.variant.traits.has_friction and task.variant.friction > 0.0,
    "backfill": lambda task: "gap_mm" in task.variant.traits.axes,
    "ucsd_rule": lambda task: _bridge(task).backfill_rule == "ucsd",
    "body": lambda task: task.variant.traits.has_body,
    "pads": lambda task: task.variant.traits.has_pads,
    "skew": lambda task: task.variant.skew_deg != 0,
    "bents": lambda task: bool(_bridge(task).bent_columns),
    "skewed_bents": lambda task: task.options.skew_of_bents_deg(task.variant.skew_deg) != 0,
    "limited_hinge": _has_limited_hinge,
}
#: Effective values of options that may be null.
_WHEN_NULL: Final[Mapping[str, Callable[[Task], Value]]] = {
    "backfill_vs_mps": lambda _: 0.0,
    "integrator": lambda task: task.settings.integrator_command,
}


def _plain(value: Any) -> Any:
    return tuple(map(_plain, value)) if isinstance(value, list) else value


CHOICES: Final = tuple(
    Choice(**{name: _plain(value) for name, value in entry.items()})
    for entry in read_yaml(Path(__file__).with_suffix(".yaml"))["choices"]
)


MOTIONS: Final = 8  # of each variant, spread over their PGV
CHOICE_CONFIDENCE: Final = 0.90  # level of the intervals
CHOICE_COLUMNS: Final[dict[str, str]] = read_yaml(COLUMNS_FILE)["modelling_choices"]
#: Columns that identify a compared value; the remaining columns describe one demand ratio.
_COMPARED: Final = list(CHOICE_COLUMNS)[:6]


def choice_pairs(tasks: Sequence[Task], choices: Sequence[Choice] = CHOICES) -> Iterator[TaskPair]:
    """Yield pairs of analyses: as configured, and with one alternative of one modelling choice."""
    for task, choice in product(tasks, choices):
        configured = choice_text(choice.key, choice.configured_in(task))
        for value in choice.alternatives(task):
            texts = ("choice", choice.key, configured, choice_text(choice.key, value))
            yield _labelled(*texts), task, choice.set_in(task, value)


def axis_pairs(
    setup: StudySetup, slug: str, axes: Mapping[str, Sequence[float]], count: int
) -> Iterator[TaskPair]:
    """Yield pairs of analyses of a variant at the smallest and largest value of each varied axis.

    Analyses without friction are also paired with friction at walls only and at keys only.
    """
    variant = setup.named(slug)
    for name, values in axes.items():
        low = min(values, key=abs)
        ends = low, max((value for value in values if value != low), key=abs, default=low)
        points = [variant.values() | {name: value} for value in ends]
        variant_at = partial(setup.study.grid.variant, variant.bridge, variant.abutment)
        variants = list(map(variant_at, points))
        if variants[0] == variants[1]:
            continue  # one value, or an axis that the model or the bridge does not have
        before, after = (sampled(setup.tasks(variant), count) for variant in variants)
        labels = _labelled("axis", name, *(choice_text(name, value) for value in ends))
        for lower, upper in zip(before, after, strict=True):
            yield labels, lower, upper
            if name == "friction" and lower.variant.friction == 0.0:
                for side in ("walls", "keys"):
                    changed = replace(upper, options=replace(upper.options, friction_at=side))
                    yield labels | {"to_value": f"{labels['to_value']} at {side}"}, lower, changed


def _labelled(*texts: str) -> dict[str, str]:
    return dict(zip(_COMPARED[2:], texts, strict=True))


def chosen_variants(variants: Iterable[Variant]) -> list[str]:
    """Return two variants of each bridge, with the middle and the largest skew.

    They have the most complete abutment model, the largest friction and the smallest gap.
    """

    def rank(variant: Variant) -> tuple[float, ...]:
        return list(ABUTMENTS).index(variant.abutment), variant.friction_pct, -variant.gap_mm

    by_bridge: dict[str, list[Variant]] = {}
    for variant in variants:
        by_bridge.setdefault(variant.bridge_name, []).append(variant)
    slugs: list[str] = []
    for group in by_bridge.values():
        top = max(map(rank, group))
        by_skew = {abs(variant.skew_deg): variant.slug for variant in group if rank(variant) == top}
        skews = sorted(by_skew)
        slugs += dict.fromkeys((by_skew[skews[len(skews) // 2]], by_skew[skews[-1]]))
    return slugs


def write_choices(
    setup: StudySetup,
    variants: Sequence[str],
    axes: Mapping[str, Sequence[float]],  # values of the grid
    output: Path,
    motions: int = MOTIONS,
) -> None:
    """Run the analyses that are not in a journal and write the table of `CHOICE_COLUMNS`."""
    setup, pairs = setup.without_alternatives, list[TaskPair]()
    for slug in variants:
        pairs += choice_pairs(sampled(setup.tasks(slug), motions))
        pairs += axis_pairs(setup, slug, axes, motions)
    tasks = [task for _, *pair in pairs for task in pair]
    rows = run_in_journal(setup, "modelling_choices", tasks)
    by_key = {row["run_key"]: row for row in rows}
    write_frame(choices_table(pairs, by_key), output, provenance())


def choices_table(pairs: Sequence[TaskPair], rows: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Return the ratios of the demands, one row per compared value and demand.

    ``rows`` maps each `run_key` to a row of the demands table. A pair is used once, and only if
    the demands of both rows are peaks over the whole motion.
    """
    distinct = {
        (*labels.values(), run_key(before), run_key(after)): (labels, before, after)
        for labels, before, after in pairs
    }
    rows_of_pairs: list[dict[str, Any]] = []
    for labels, task, changed_task in distinct.values():
        runs = rows[run_key(task)], rows[run_key(changed_task)]
        keys = {"bridge": task.variant.bridge_name, "abutment": task.variant.abutment, **labels}
        keys["motion"] = task.motion.motion.motion_id
        has_failed = any(row["status"] != OK or row[BEYOND_MODEL] for row in runs)
        for demand in demands_for("effect"):
            has_ratio = not has_failed and all(float(row[demand]) > 0.0 for row in runs)
            log_ratio = np.log(runs[1][demand] / runs[0][demand]) if has_ratio else np.nan
            rows_of_pairs.append(keys | {"demand": demand, "log": log_ratio, "failed": has_failed})
    table = pd.DataFrame(rows_of_pairs)
    groups = table.groupby([*_COMPARED, "demand"], sort=False)
    by_motion = table.groupby([*_COMPARED, "demand", "motion"], sort=False)["log"].mean()
    means = by_motion.groupby([*_COMPARED, "demand"], sort=False).agg(["mean", "sem", "count"])
    half_width = means["sem"] * student.ppf(0.5 + CHOICE_CONFIDENCE / 2, means["count"] - 1)
    limits = {"ci_low": means["mean"] - half_width, "ci_high": means["mean"] + half_width}
    extremes = {"lowest": groups["log"].min(), "highest": groups["log"].max()}
    ratios = pd.DataFrame({"ratio": groups["log"].mean()} | limits | extremes).apply(np.exp)
    counts = groups.agg(n=("log", "count"), n_failed=("failed", "sum"), n_pairs=("failed", "size"))
    return ratios.join(counts).reset_index()
