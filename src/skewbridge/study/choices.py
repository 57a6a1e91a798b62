"""The choices of the modeller as data: a new one is a row of `CHOICES`.

Each is an option that another engineer could as well have set otherwise. `study.modelling_choices`
sets them one at a time and compares the demands with those of the configured model.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

from skewbridge.analysis.modal import damping_ratio
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.study.task import Task
from skewbridge.units import MN, split_unit
from skewbridge.variant.variant import Variant

type Value = bool | float | str | tuple[str | float, ...]

_PARTS: Final = {"model": "options", "analysis": "settings"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One option and the values to try.

    Attributes:
        key: Key of the section.
        label: Short name in figures and on the page.
        values: What to try; the configured one among them is passed over.
        source: Why these values.
        section: Section of the configuration.
        acts_on: Whether the option changes the model of a variant.
        when_null: The value of an analysis whose option is null.
    """

    key: str
    label: str
    values: tuple[Value, ...]
    source: str
    section: Literal["model", "analysis"] = "model"
    acts_on: Callable[[Variant], bool] = lambda _: True
    when_null: Callable[[Task], Value] | None = None

    def configured_in(self, task: Task) -> Value:
        """Return the value that an analysis has."""
        part = task.settings if self.section == "analysis" else _effective_options(task)
        value: Value | None = getattr(part, self.key)
        if value is not None:
            return value
        if self.when_null is None:
            raise ValueError(f"choice {self.key}: nothing says what null stands for")
        return self.when_null(task)

    def set_in(self, task: Task, value: Value) -> Task:
        """Return an analysis with another value of the option."""
        part = _PARTS[self.section]
        return replace(task, **{part: replace(getattr(task, part), **{self.key: value})})

    def alternatives(self, task: Task) -> list[Value]:
        """Return the values that make another analysis of this one.

        None where the option does not act on the variant, or where the scheme sets it anyway.
        """
        if not self.acts_on(task.variant):
            return []
        configured, before = self.configured_in(task), _effective(task)
        others = [value for value in self.values if value != configured]
        return [value for value in others if _effective(self.set_in(task, value)) != before]


def _has_keys(variant: Variant) -> bool:
    return variant.traits.has_wall_points


def _has_walls(variant: Variant) -> bool:
    return variant.traits.has_contacts


def _has_backfill(variant: Variant) -> bool:
    return "gap_mm" in variant.traits.axes


def _has_pads(variant: Variant) -> bool:
    return variant.traits.has_pads


CHOICES: Final = (
    Choice(
        key="key_frame",
        label="Key frame",
        values=("skewed", "deck_edge"),
        source="faces across the abutment line, as the paper's springs, or along the deck's edge",
        acts_on=lambda variant: _has_keys(variant) and variant.skew_deg != 0,
    ),
    Choice(
        key="keys",
        label="Shear keys",
        values=("sacrificial", "monolithic"),
        source="the two backbones of the bridge's file: keys that break, or that hold",
        acts_on=_has_keys,
    ),
    Choice(
        key="transverse_gap_mm",
        label="Key gap",
        values=(0.0, 6.4, 25.4),
        source="no gap, the paper's, and 1 in",
        acts_on=_has_keys,
    ),
    Choice(
        key="gap_measured",
        label="Gap measured",
        values=("normal", "longitudinal"),
        source="the opening across the joint, or along the bridge as drawings may give it",
        acts_on=lambda variant: _has_backfill(variant) and variant.skew_deg != 0,
    ),
    Choice(
        key="wall_mass",
        label="Wall mass",
        values=(False, True),
        source="walls and keys without inertia of their own, or with it as in the paper",
        acts_on=_has_keys,
    ),
    Choice(
        key="wall_dashpot_ratio",
        label="Wall dashpot",
        values=(0.02, 0.10, 0.30),
        source="no test is known: a fifth and three times the configured ratio",
        acts_on=_has_keys,
    ),
    Choice(
        key="wall_restoring_n_per_m",
        label="Wall restoring spring",
        values=(3.0e4, 3.0e5, 3.0e6),
        source="no test is known: a tenth and ten times the configured stiffness",
        acts_on=_has_walls,
    ),
    Choice(
        key="backfill",
        label="Backfill curve",
        values=("hyperbolic", "sdc"),
        source="UCSD tests, or the bilinear curve of SDC 2.0",
        acts_on=_has_backfill,
    ),
    Choice(
        key="backfill_variation",
        label="Backfill variation",
        values=(0.0, 0.3),
        source="uniform, or Kaviani's 30 % along the wall",
        acts_on=lambda variant: _has_backfill(variant) and variant.skew_deg != 0,
    ),
    Choice(
        key="embankment_mass",
        label="Embankment mass",
        values=(False, True),
        source="Zhang and Makris: the embankment moves with the abutment, or not",
        acts_on=lambda variant: variant.traits.has_body,
    ),
    Choice(
        key="pad_strength_factor",
        label="Pad strength",
        values=(0.5, 1.0, 2.0),
        source="pads that slide early on their seats, or do not yield as soon",
        acts_on=_has_pads,
    ),
    Choice(
        key="foundation",
        label="Foundation",
        values=("fixed", "springs"),
        source="springs of the bridge's file, where it has them",
        acts_on=lambda variant: load_bridge(variant.bridge).foundation is not None,
    ),
    Choice(
        key="column_integration",
        label="Column plasticity",
        values=("hinge_radau", "lobatto5"),
        source="hinges of a given length, or distributed as in the paper",
    ),
    Choice(
        key="damping_ratio",
        label="Damping ratio",
        values=(0.02, 0.05),
        source="the paper gives none; 2 to 5 % are usual for concrete bridges",
        when_null=lambda task: damping_ratio(load_bridge(task.variant.bridge), task.options),
    ),
    Choice(
        key="integrator",
        label="Integrator",
        values=(("Newmark", 0.5, 0.25), ("HHT", 0.7)),
        # not Houbolt, which starts anew at every change of the step
        source="without numerical damping, and with more",
        section="analysis",
        when_null=lambda task: task.settings.integrator_command,
    ),
)


def value_text(key: str, value: Value) -> str:
    """Return a value of an option as tables and figures show it, with its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return " ".join(value_text("", part) for part in value)
    if isinstance(value, str):
        return value.replace("_", " ")
    unit = split_unit(key)[1]
    if unit == "N/m":
        value, unit = value / MN, "MN/m"
    return f"{value:g}" if unit == "-" else f"{value:g} {unit}"


def _effective_options(task: Task) -> object:
    return task.settings.model_options(task.options)


def _effective(task: Task) -> tuple[object, object]:
    return task.settings, _effective_options(task)
