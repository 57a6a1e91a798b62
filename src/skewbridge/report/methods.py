"""Methods section of a paper, with citations, written from the configuration of a study."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import ClassVar, Final

import pandas as pd
import yaml

from skewbridge.bridge.frame import Structure
from skewbridge.bridge.library import load_structure
from skewbridge.demands.columns import choice_text, joint_columns
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.settings import EFFECT_CONFIDENCE
from skewbridge.motions.levels import LEVEL_MEASURE
from skewbridge.report import answer, appearance
from skewbridge.report.answer import ignored_by_all, listed, option_text, texts_with_own
from skewbridge.report.appearance import in_words, plain_label, threshold_text, value_text
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig, parse_config
from skewbridge.units import split_unit
from skewbridge.variant.axes import axis
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.random_properties import BLOCK, DIRECTION, property_name
from skewbridge.variant.variant import ABUTMENTS

#: Full references by their key in the text.
REFERENCES: Final[Mapping[str, str]] = yaml.safe_load(
    (files("skewbridge.report") / "references.yaml").read_text("utf-8")
)
#: Sections that do not change the results, or that the paragraphs describe in full.
_NO_METHOD: Final = {"results", "accuracy", "grid", "figures", "batches", "checks", "uncertainty"}
_INTEGRATORS: Final = {
    "Newmark": "Newmark's method (Newmark 1959)",
    "Houbolt": "Houbolt's method (Houbolt 1950)",
    "HHT": "the HHT method (Hilber et al. 1977)",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Methods:
    """Text, limit states and references of the methods section of a study."""

    parts: Mapping[str, str]  # paragraphs by subject
    states: Sequence[Sequence[str]]  # limit states: cells under `heads`
    references: Sequence[str]  # cited works in full, sorted
    heads: ClassVar = ("component", "demand", "median", "dispersion", "source")

    def markdown(self) -> str:
        """Return the methods as a page of Markdown."""
        text = "\n".join(f"**{name}.** {text}\n" for name, text in self.parts.items())
        rows = [[cell.replace("|", "/") for cell in row] for row in self.states]
        table = [self.heads, ["---"] * len(self.heads), *rows]
        states = "\n".join(f"| {' | '.join(row)} |" for row in table)
        works = "\n".join(f"- {work}" for work in self.references)
        return f"# Methods\n\n{text}\n## Limit states\n\n{states}\n\n## References\n\n{works}\n"


def methods_of(config: StudyConfig, suite: pd.DataFrame | None = None) -> Methods:
    """Return paragraphs on models, motions, analyses and statistics, and the references in them.

    The configuration does not state site and purpose, so the author must add them. ``suite`` is the
    table of the prepared motions. `InputError` if a bridge or the limit states cannot be read.
    """
    motions, drawn = config.motions, config.uncertainty.drawn
    alternatives = config.uncertainty.alternatives if config.uncertainty.enabled else {}
    suite = pd.DataFrame({"source": []}) if suite is None else suite
    count, levels_g = motions.count, motions.level_range_g
    if {"scale", LEVEL_MEASURE} <= set(suite):
        applied_g = suite["scale"] * suite[LEVEL_MEASURE]
        count, levels_g = suite["motion_id"].nunique(), (applied_g.min(), applied_g.max())
    sizes = suite.groupby("stripe_g").size() if "stripe_g" in suite else pd.Series(dtype=int)
    suites = suite.groupby("suite", sort=False)["motion_id"].nunique() if "suite" in suite else {}
    bridges = [load_structure(name) for name in config.grid.bridge]
    model = config.analysis.model_options(config.model)
    dampings = {model.damping_factor * bridge.description.damping_ratio for bridge in bridges}
    values = {
        name: ", ".join(value_text(axis(name), value) for value in values)
        for name, values in config.grid.values().items()
    }
    axes, ignored = texts_with_own(values, bridges), ignored_by_all(bridges)
    environment = appearance.templates(vars(appearance), vars(answer), globals())
    template = environment.get_template("methods.j2")
    context = template.new_context(
        {
            **template.globals,
            "version": version,
            "config": config,
            "bridges": bridges,
            "with_columns": [bridge for bridge in bridges if bridge.description.bent_columns],
            "model": model,
            "dampings": [percent(ratio) for ratio in sorted(dampings)],
            "abutments": [ABUTMENTS[name] for name in config.grid.abutment],
            "axes": [f"{axis(name).title} {text}" for name, text in axes.items()],
            "variants": len(expand_grid(config.grid)),
            "within": [axis(name).title for name in getattr(motions.blocks, "within", ())],
            "count": count,
            "levels_g": levels_g,
            "stripes_g": sizes.index.tolist() or motions.stripes_g,
            "sizes": sizes.tolist() if sizes.nunique() > 1 or sizes.max() != count else [],
            "measure": f"Sa_avg (Eads et al. 2015) at the T1 of {CONDITIONING_BRIDGE}",
            "source": "; ".join(filter(None, suite["source"].astype(str).unique())),
            "suites": dict(suites),
            "random_direction": DIRECTION in drawn,
            "drawn": {
                f"{property_name(name)} ({split_unit(name)[1]})".removesuffix(" (-)"): distribution
                for name, distribution in drawn.items()
                if name not in ignored
            },
            "alternatives": {
                option_text(name): listed(choice_text(name, value) for value in values)
                for name, values in alternatives.items()
            },
            "block_size": BLOCK,
            "integrator": _INTEGRATORS[str(config.analysis.integrator_command[0])],
            "effect_confidence": EFFECT_CONFIDENCE,
            "im": plain_label(config.fragility.im),
            "changed": _changed_settings(config),
        }
    )
    paragraphs = {
        name.replace("_", " ").capitalize(): " ".join("".join(paragraph(context)).split())
        for name, paragraph in template.blocks.items()
    }
    states = _limit_states(config, bridges)
    text = " ".join([*paragraphs.values(), *chain(*states)])
    cited = sorted(key for key in REFERENCES if re.search(rf"{re.escape(key)}(?! \d)", text))
    return Methods(parts=paragraphs, states=states, references=[REFERENCES[key] for key in cited])


def _changed_settings(config: StudyConfig) -> list[str]:
    """Return each setting that differs from its default at the same accuracy, as text."""
    configured = config.model_dump(mode="json", exclude=_NO_METHOD)
    defaults = parse_config({"accuracy": config.accuracy}).model_dump(mode="json")
    accuracy = [f"`accuracy` {config.accuracy}"] if config.accuracy != "default" else []
    return accuracy + [
        f"`{section}.{key}` {numbers(value)} (default {numbers(defaults[section][key])})"
        for section, values in configured.items()
        for key, value in values.items()
        if value != defaults[section][key]
    ]


def _limit_states(config: StudyConfig, bridges: Sequence[Structure]) -> list[list[str]]:
    rows: list[list[str]] = []
    has_joints = any(bridge.description.joints_m for bridge in bridges)
    has_columns = any(bridge.description.bent_columns for bridge in bridges)
    states = load_limit_states(Path(config.fragility.limit_states))
    states = [item for item in states if has_joints or not joint_columns([item.demand])]
    states = [item for item in states if has_columns or not item.demand.startswith("column_")]
    for component in dict.fromkeys(state.component for state in states):
        group = [state for state in states if state.component == component]
        medians = (f"{item.name} {threshold_text(item.demand, item.threshold)}" for item in group)
        dispersion = numbers(sorted({item.dispersion for item in group}))
        citation = " ".join(group[0].citation.split())
        demand, median = f"`{group[0].demand}`", ", ".join(medians)
        rows.append([in_words(component), demand, median, dispersion, citation])
    return rows


def numbers(value: object) -> str:
    """Return a value of the configuration, or a list or dictionary of them, as text."""
    if isinstance(value, Mapping):
        return f"({'; '.join(f'{key} {numbers(item)}' for key, item in value.items())})"
    if isinstance(value, list | tuple):
        return ", ".join(map(numbers, value))
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)


def percent(share: float) -> str:
    """Return a share in per cent as text."""
    return f"{100 * share:g} %"
