"""Effects of modelling choices compared with those of friction, gap and skew (`CHOICES`).

Each choice is an option that another engineer could have set otherwise. It is changed alone
on a few motions, and the demands are compared with those of the configured model motion by motion,
next to the axes of the grid, from their lowest to their highest value on the same motions.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
import pandas as pd
from scipy.stats import t as student

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.hinge import hinge_length_m
from skewbridge.demands.columns import demands_for
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.statuses import OK
from skewbridge.units import MN, split_unit
from skewbridge.variant.variant import Variant, parse_slug

if TYPE_CHECKING:
    # The processes that draw the figures need the table of the choices and no OpenSees.
    from skewbridge.study.analyses import StudySetup
    from skewbridge.study.batch import Workers
    from skewbridge.study.task import Task

type Value = bool | float | str | tuple[str | float, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """One option and the values to try.

    Attributes:
        values: Values to try; the configured one is skipped.
        source: Reason for these values.
        section: Section of the configuration.
        acts_on: Whether the option changes the model of a variant.
        when_null: Effective value where the option is null.
        needs: Key of ``model`` and the value without which the option has no alternative.
    """

    key: str
    label: str
    values: tuple[Value, ...]
    source: str
    section: Literal["model", "analysis"] = "model"
    acts_on: Callable[[Variant], bool] = lambda _: True
    when_null: Callable[["Task"], Value] | None = None
    needs: tuple[str, Value] | None = None

    def configured_in(self, task: "Task") -> Value:
        """Return the value of the option in an analysis, without the draw of the motion."""
        settings, options = _effective(task)
        value: Any = getattr(settings if self.section == "analysis" else options, self.key)
        if self.key in task.draw:
            return round(value / task.draw[self.key], 9)
        if value is not None:
            return value
        if self.when_null is None:
            raise ValueError(f"choice {self.key}: when_null must state the meaning of null")
        return self.when_null(task)

    def set_in(self, task: "Task", value: Value) -> "Task":
        """Return an analysis with another value of the option, times the draw of the motion."""
        if self.key in task.draw and isinstance(value, float):
            value *= task.draw[self.key]
        if self.section == "analysis":
            return replace(task, settings=replace(task.settings, **{self.key: value}))
        return replace(task, options=replace(task.options, **{self.key: value}))

    def alternatives(self, task: "Task") -> list[Value]:
        """Return the values that change an analysis.

        None where the option does not act on the variant, or where the scheme sets it anyway.
        """
        if not self.acts_on(task.variant):
            return []
        configured, before = self.configured_in(task), _effective(task)
        if self.needs and getattr(before[1], self.needs[0]) != self.needs[1]:
            return []
        others = [value for value in self.values if value != configured]
        return [value for value in others if _effective(self.set_in(task, value)) != before]


def _effective(task: "Task") -> tuple[object, object]:
    """Return the settings of an analysis, and the options of its model under its scheme."""
    return task.settings, task.settings.model_options(task.options)


def _has_keys(variant: Variant) -> bool:
    return variant.traits.has_wall_points


def _has_backfill(variant: Variant) -> bool:
    return "gap_mm" in variant.traits.axes


def _has_limited_hinge(variant: Variant) -> bool:
    bridge = load_bridge(variant.bridge)
    return any(
        hinge_length_m(bridge, bent, "sdc") != hinge_length_m(bridge, bent, "paulay_priestley")
        for bent in range(len(bridge.bents))
    )


# fmt: off
CHOICES: Final = (
    Choice("key_frame", "Key frame", ("skewed", "deck_edge"),
           "faces across the abutment line, as the paper's springs, or along the deck's edge",
           acts_on=lambda variant: _has_keys(variant) and variant.skew_deg != 0),
    Choice("keys", "Shear keys", ("sacrificial", "monolithic"),
           "the two backbones of the bridge's file: keys that break, or that do not",
           acts_on=_has_keys),
    Choice("friction_at", "Friction at", ("all", "walls", "keys"),
           "which contacts have the friction of the variant",
           acts_on=lambda variant: variant.traits.has_friction and variant.friction > 0.0),
    Choice("backwall_points", "Points of a backwall", (3, 9),
           "the mesh of the contact along the wall",
           acts_on=lambda variant: variant.traits.has_contacts),
    Choice("key_along_face", "Keys along their face", ("backbone", "elastic"),
           "limited by the strength across the face, or elastic", acts_on=_has_keys),
    Choice("transverse_gap_mm", "Key gap", (0.0, 6.4, 25.4),
           "no gap, the paper's, and 1 in", acts_on=_has_keys),
    Choice("gap_measured", "Gap measured", ("normal", "longitudinal"),
           "the opening across the joint, or along the bridge as drawings may give it",
           acts_on=lambda variant: _has_backfill(variant) and variant.skew_deg != 0),
    Choice("wall_mass", "Wall mass", (False, True),
           "walls and keys without inertia of their own, or with it as in the paper",
           acts_on=_has_keys),
    Choice("backfill_vs_mps", "Radiation: Vs of the backfill", (15.0, 50.0, 150.0, 500.0),
           "a third and three times the configured velocity; 15 m/s is 10 % of critical for the "
           "mass of a wall", acts_on=_has_keys, when_null=lambda _: 0.0),
    Choice("wall_restoring_n_per_m", "Wall restoring spring", (3.0e4, 3.0e5, 3.0e6),
           "no test is known: a tenth and ten times the configured stiffness",
           acts_on=lambda variant: variant.traits.has_contacts),
    Choice("backfill", "Backfill curve", ("hyperbolic", "sdc"),
           "UCSD tests, or the bilinear curve of SDC 2.0", acts_on=_has_backfill),
    Choice("backfill_height_exponent", "Backfill strength with height", (1.0, 1.5),
           "linear as in the earlier criteria, or as measured in granular soil",
           acts_on=lambda variant: (_has_backfill(variant) and
                                    load_bridge(variant.bridge).abutment.backfill.rule == "ucsd")),
    Choice("backfill_variation", "Backfill variation", (0.0, 0.3),
           "uniform, or Kaviani's 30 % along the wall",
           acts_on=lambda variant: _has_backfill(variant) and variant.skew_deg != 0),
    Choice("embankment_mass", "Embankment mass", (False, True),
           "Zhang and Makris: the embankment moves with the abutment, or not",
           acts_on=lambda variant: variant.traits.has_body),
    Choice("pad_strength_factor", "Pad strength", (0.5, 1.0, 2.0),
           "pads that slide early on their seats, or do not yield as soon",
           acts_on=lambda variant: variant.traits.has_pads),
    Choice("foundation", "Foundation", ("fixed", "springs"),
           "springs of the bridge's file, where it has them",
           acts_on=lambda variant: load_bridge(variant.bridge).foundation is not None),
    Choice("column_integration", "Column plasticity", ("hinge_radau", "lobatto5"),
           "hinges of a given length, or distributed as in the paper",
           needs=("shear_failure", "flag")),
    Choice("hinge_rule", "Hinge length", ("sdc", "paulay_priestley"),
           "with and without the lower limit of the criteria", acts_on=_has_limited_hinge),
    Choice("fiber_end", "Fibers at their ultimate strain", ("loss", "none"),
           "core and bars lose their strength, or nothing changes as in the paper"),
    Choice("shear_model", "Shear capacity", ("sdc_expected", "sdc_nominal", "kowalsky_priestley"),
           "the criteria with expected or specified strengths, or the revised UCSD model"),
    Choice("shear_failure", "Shear failure", ("flag", "degrade"),
           "the analysis goes on without it, or with a softening section",
           needs=("column_integration", "hinge_radau")),
    Choice("cap_load", "Dead load on the cap", ("spread", "middle"),
           "over the width of the deck, or in the middle as in spine models",
           acts_on=lambda variant: any(b.columns > 1 for b in load_bridge(variant.bridge).bents)),
    Choice("damping_ratio", "Damping ratio", (0.02, 0.05),
           "the paper gives none; 2 to 5 % are usual for concrete bridges",
           when_null=lambda task: load_bridge(task.variant.bridge).damping.ratio),
    # not Houbolt, which restarts at every change of the step
    Choice("integrator", "Integrator", (("Newmark", 0.5, 0.25), ("HHT", 0.7)),
           "without numerical damping, and with more", section="analysis",
           when_null=lambda task: task.settings.integrator_command),
)
# fmt: on


def choice_text(key: str, value: Value) -> str:
    """Return a value of an option as tables and figures show it, with its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return " ".join(choice_text("", part) for part in value)
    if isinstance(value, str):
        return value.replace("_", " ")
    unit = split_unit(key)[1]
    if unit == "N/m":
        value, unit = value / MN, "MN/m"
    return f"{value:g}" if unit == "-" else f"{value:g} {unit}"


CHOICE_CONFIDENCE: Final = 0.90
#: Columns of the table with their meaning.
CHOICE_COLUMNS: Final = {
    "bridge": "bridge",
    "abutment": "abutment model",
    "kind": "`choice` of the modeller, or `axis` of the grid",
    "name": "key of the option, or name of the axis",
    "from_value": "configured value; of an axis the lowest (skew: smallest angle)",
    "to_value": "value tried; of an axis the highest",
    "demand": "demand column",
    "ratio": "geometric mean of the demand at to_value over that at from_value",
    "ci_low": f"lower end of its {CHOICE_CONFIDENCE:.0%} interval (t, means of the motions)",
    "ci_high": "upper end of its interval",
    "lowest": "smallest ratio of one pair",
    "highest": "largest ratio of one pair",
    "n": "pairs in which both runs ended `ok`, demand above zero",
    "n_failed": "pairs in which a run did not end `ok`",
    "n_pairs": "all pairs: variants times motions",
}
#: Columns of one value compared; the others are of its ratio for one demand.
_COMPARED: Final = list(CHOICE_COLUMNS)[:6]


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskPair:
    """Two analyses that differ in one modelling option (kind ``choice``) or one axis.

    The two values are stored as text.
    """

    kind: str
    name: str
    from_value: str
    to_value: str
    before: "Task"
    after: "Task"


def choice_pairs(
    tasks: Sequence["Task"], choices: Sequence[Choice] = CHOICES
) -> Iterator[TaskPair]:
    """Yield each analysis with each alternative of each choice that acts on it."""
    for task in tasks:
        for choice in choices:
            configured = choice_text(choice.key, choice.configured_in(task))
            for value in choice.alternatives(task):
                yield TaskPair(
                    kind="choice",
                    name=choice.key,
                    from_value=configured,
                    to_value=choice_text(choice.key, value),
                    before=task,
                    after=choice.set_in(task, value),
                )


def axis_pairs(
    setup: "StudySetup", slug: str, axes: Mapping[str, Sequence[float]], count: int
) -> Iterator[TaskPair]:
    """Yield the analyses of a variant at the ends of each axis of the grid that has two values."""
    from skewbridge.study.analyses import sampled

    variant = parse_slug(slug)
    for name, values in axes.items():
        low, high = (end(values, key=abs) for end in (min, max))
        points = [variant.values() | {name: value} for value in (low, high)]
        ends = [Variant.at(variant.bridge, variant.abutment, point) for point in points]
        slugs = [end.normalised().slug for end in ends]
        if slugs[0] == slugs[1]:
            continue  # one value, or an axis that the abutment model does not have
        before, after = (sampled(setup.tasks(slug), count) for slug in slugs)
        texts = {"from_value": choice_text(name, low), "to_value": choice_text(name, high)}
        for one, other in zip(before, after, strict=True):
            yield TaskPair(kind="axis", name=name, **texts, before=one, after=other)


def friction_split(
    setup: "StudySetup", slug: str, axes: Mapping[str, Sequence[float]], count: int
) -> Iterator[TaskPair]:
    """Yield the analyses without friction and with that of walls or keys only.

    Together with the pair of the axis they divide the effect of friction between both places.
    """
    for pair in axis_pairs(setup, slug, {"friction": axes.get("friction", (0.0,))}, count):
        if pair.before.variant.friction == 0.0:
            for place in ("walls", "keys"):
                after = replace(pair.after, options=replace(pair.after.options, friction_at=place))
                yield replace(pair, to_value=f"{pair.to_value} at {place}", after=after)


def write_choices(
    setup: "StudySetup",
    variants: Sequence[str],
    axes: Mapping[str, Sequence[float]],
    *,
    motions: int,
    workers: "Workers",
    output: Path,
) -> None:
    """Run the analyses that no journal has and write the table of `CHOICE_COLUMNS`.

    Each of the variants is changed under `motions` motions; `axes` has the values of the grid.
    """
    from skewbridge.study.analyses import run_in_journal, sampled

    pairs: list[TaskPair] = []
    for slug in variants:
        pairs += choice_pairs(sampled(setup.tasks(slug), motions))
        pairs += axis_pairs(setup, slug, axes, motions)
        pairs += friction_split(setup, slug, axes, motions)
    tasks = [task for pair in pairs for task in (pair.before, pair.after)]
    rows = run_in_journal(setup, "modelling_choices", tasks, workers)
    by_key = {row["run_key"]: row for row in rows}
    write_frame(choices_table(pairs, by_key), output, provenance())


def choices_table(pairs: Sequence[TaskPair], rows: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Return the ratios of the demands, one row per value compared and demand.

    The rows are those of the demands table by `run_key`; a repeated pair counts once.
    """
    from skewbridge.study.task import run_key

    table = pd.DataFrame(
        {
            "bridge": pair.before.variant.bridge_name,
            "abutment": pair.before.variant.abutment,
            **{name: getattr(pair, name) for name in _COMPARED[2:]},
            "motion": pair.before.motion.motion.motion_id,
            "demand": demand,
            **_compared(rows[before], rows[after], demand),
        }
        for (before, after), pair in {
            (run_key(pair.before), run_key(pair.after)): pair for pair in pairs
        }.items()
        for demand in demands_for("effect")
    )
    logs = table.groupby([*_COMPARED, "demand"], sort=False)
    by_motion = table.groupby([*_COMPARED, "demand", "motion"], sort=False)["log"].mean()
    means = by_motion.groupby([*_COMPARED, "demand"], sort=False).agg(["mean", "sem", "count"])
    reach = means["sem"] * student.ppf(0.5 + CHOICE_CONFIDENCE / 2, means["count"] - 1)
    ratios = {
        "ratio": logs["log"].mean(),
        "ci_low": means["mean"] - reach,
        "ci_high": means["mean"] + reach,
        "lowest": logs["log"].min(),
        "highest": logs["log"].max(),
    }
    counts = logs.agg(n=("log", "count"), n_failed=("failed", "sum"), n_pairs=("failed", "size"))
    return pd.DataFrame(ratios).apply(np.exp).join(counts).reset_index()


def _compared(before: Mapping[str, Any], after: Mapping[str, Any], demand: str) -> dict[str, Any]:
    bottom, top = float(before[demand]), float(after[demand])
    failed = not before["status"] == after["status"] == OK
    usable = not failed and bottom > 0.0 and top > 0.0
    return {"log": np.log(top / bottom) if usable else np.nan, "failed": failed}
