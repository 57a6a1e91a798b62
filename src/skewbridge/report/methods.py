"""Methods of a study as paragraphs for a paper, with citations, from its configuration."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Final

import pandas as pd
import yaml

from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.fragility.limit_states import LimitState, load_limit_states
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.levels import LEVEL_MEASURE, MotionsConfig
from skewbridge.report.answer import counted
from skewbridge.report.axis_layout import (
    in_words,
    plain_label,
    shown_length,
    threshold_text,
    value_text,
)
from skewbridge.study.config import StudyConfig, parse_config
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import axis
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import (
    BLOCK,
    DIRECTION,
    UncertaintyConfig,
    property_name,
)

#: Full references by their key in the text.
REFERENCES: Final[Mapping[str, str]] = yaml.safe_load(
    (files("skewbridge.report") / "references.yaml").read_text("utf-8")
)
#: Sections that change no number of a study, or that other sentences describe in full.
_NO_METHOD: Final = {"results", "accuracy", "grid", "figures", "batches", "checks",
                     "max_unfinished_share", "modelling_choices", "uncertainty"}  # fmt: skip
#: Heads of the table of limit states.
STATE_HEADS: Final = ("component", "demand", "median", "dispersion", "source")
_CONTACT: Final = (
    "Contact is a normal penalty spring behind a gap, with tangential elastic-plastic springs "
    "whose yield force is updated during the analysis by the normal force (Rahman and Mackie 2023; "
    "Rahman and Mackie)"
)


_INTEGRATORS: Final = {
    "Newmark": "Newmark's method (Newmark 1959)",
    "Houbolt": "Houbolt's method (Houbolt 1950)",
    "HHT": "the HHT method (Hilber et al. 1977)",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Methods:
    """Methods of a study."""

    parts: Mapping[str, str]  # paragraphs by their subject
    states: Sequence[Sequence[str]]  # limit states: cells under `STATE_HEADS`
    references: Sequence[str]  # cited works in full, sorted

    def markdown(self) -> str:
        """Return the methods as a page of Markdown."""
        text = "\n".join(f"**{name}.** {text}\n" for name, text in self.parts.items())
        rows = [" | ".join(cell.replace("|", "/") for cell in row) for row in self.states]
        rules = " | ".join("---" for _ in STATE_HEADS)
        table = "\n".join(f"| {row} |" for row in (" | ".join(STATE_HEADS), rules, *rows))
        listed = "\n".join(f"- {work}" for work in self.references)
        return f"# Methods\n\n{text}\n## Limit states\n\n{table}\n\n## References\n\n{listed}\n"


def methods_of(config: StudyConfig, suite: pd.DataFrame | None = None) -> Methods:
    """Return paragraphs on models, motions, analyses and statistics, and the references in them.

    Site and purpose are not in a configuration; the reader adds them. ``suite`` is the table of the
    prepared motions.

    Raises:
        InputError: A bridge or the limit states of the study cannot be read.
    """
    sources = [] if suite is None else list(dict.fromkeys(suite["source"].astype(str)))
    bridges = [load_bridge(name) for name in config.grid.bridge]
    paragraphs = {
        "Bridges": _bridges(bridges, config.analysis.model_options(config.model)),
        "Abutments": _abutments(config),
        "Ground motions": _motions(config, suite, "; ".join(filter(None, sources))),
        "Random properties": _random_properties(config.uncertainty),
        "Analyses": _analyses(config),
        "Statistics": _statistics(config.fragility, config.motions),
        "Settings": _changed_settings(config),
    }
    parts = {name: " ".join(sentences) for name, sentences in paragraphs.items()}
    states = _limit_states(config)
    text = " ".join([*parts.values(), *chain(*states)])
    cited = sorted(key for key in REFERENCES if re.search(rf"{re.escape(key)}(?! \d)", text))
    return Methods(parts=parts, states=states, references=[REFERENCES[key] for key in cited])


def _bridges(bridges: Sequence[BridgeData], model: ModelOptions) -> Iterator[str]:
    several = len(bridges) > 1
    facts = "; ".join(
        f"{bridge.title}: {counted(len(bridge.spans_m), 'span')}, {shown_length(bridge.length_m)}, "
        f"{bridge.base} column bases, T1 = {bridge.t1_s:.3g} s"
        for bridge in bridges
    )
    yield (
        f"{counted(len(bridges), 'bridge').capitalize()} {'were' if several else 'was'} modelled "
        f"in OpenSees (McKenna et al. 2010) through OpenSeesPy {version('openseespy')} (Zhu et al. "
        f"2018) with skewbridge {version('skewbridge')} ({facts})."
    )
    if any(bridge.details == "surrogate" for bridge in bridges):
        yield (
            "Details that are not public (deck section, reinforcement, abutments) are surrogates; "
            "the file of the bridge gives the source of every number."
        )
    columns = (
        "The columns are force-based fiber elements with distributed plasticity (five Lobatto "
        "points) and Mander's concrete (Mander et al. 1988)."
    )
    if model.elastic_columns:
        columns = "The columns are elastic with cracked stiffness."
    elif model.column_integration == "hinge_radau":
        rule = "Caltrans 2013" if model.hinge_rule == "sdc" else "Paulay and Priestley 1992"
        columns = (
            "The columns are force-based fiber elements with plastic hinges (Scott and Fenves "
            f"2006) of a length by rule ({rule}), unless the file of the bridge gives it, and "
            "Mander's concrete (Mander et al. 1988)."
        )
    deck = counted(model.deck_elements_per_span, "element")
    yield f"The deck is an elastic spine of {deck} per span. {columns}"
    capacity = "is the revised UCSD model (Kowalsky and Priestley 2000)"
    if model.shear_model != "kowalsky_priestley":
        materials = model.shear_model.removeprefix("sdc_")
        capacity = f"follows the Caltrans criteria with {materials} materials (Caltrans 2013)"
    yield f"Column shear capacity {capacity}."
    if model.shear_failure == "flag":
        yield "An analysis in which a column reaches it counts as a shear failure of that column."
    else:
        yield "A column that reaches it loses its shear strength."
    ratios = sorted({model.damping_ratio or bridge.damping.ratio for bridge in bridges})
    shown = " and ".join(f"{100 * ratio:g} %" for ratio in ratios)
    yield f"Rayleigh damping of deck and columns is {shown} of critical at two periods."
    bases = "rigid ground" if model.foundation == "fixed" else "foundation springs"
    yield f"Column bases rest on {bases}."


def _abutments(config: StudyConfig) -> Iterator[str]:
    traits = [ABUTMENTS[name] for name in config.grid.abutment]
    models = "; ".join(each.description for each in traits)
    yield f"The seat-type abutments are modelled {models}."
    model = config.analysis.model_options(config.model)
    if any(each.has_contacts for each in traits):
        update = "predicted at the end of each step"
        if model.coupling == "lagged":
            update = "of the last committed step"
        points = counted(model.backwall_points, "point")
        yield f"{_CONTACT}, {update}; {points} are placed along each backwall."
    backfills = {each.backfill for each in traits} - {"none"}
    if model.backfill == "sdc" and backfills:
        yield "The backfill is bilinear (Caltrans 2019)."
    elif "option" in backfills:
        yield "The backfill is hyperbolic."
    axes = "; ".join(
        f"{axis(name).title} {', '.join(value_text(axis(name), value) for value in values)}"
        for name, values in config.grid.values().items()
    )
    count = len(expand_grid(config.grid))
    way = "normal to the backwall" if model.gap_measured == "normal" else "along the bridge"
    yield (
        f"The study crosses {axes}: {counted(count, 'variant')}. The gap is the opening of the "
        f"joint at rest, {way}."
    )


def _motions(config: StudyConfig, suite: pd.DataFrame | None, source: str) -> Iterator[str]:
    motions = config.motions
    count = "All" if motions.count is None else f"{motions.count}"
    cited = f" ({_cited_source(source)})" if source else ""
    low, high = motions.level_range_g
    if suite is not None and {"scale", LEVEL_MEASURE} <= set(suite):
        count = f"{len(suite)}"
        levels_g = suite["scale"] * suite[LEVEL_MEASURE]
        low, high = levels_g.min(), levels_g.max()
    scaled = {
        "scaled_cloud": f"each with one factor, the same for all bridges and variants, so that "
        f"Sa_avg (Eads et al. 2015) spans {low:.3g} to {high:.3g} g",
        "cloud": "unscaled",
        "stripes": f"scaled to {_listed(motions.stripes_g)} g of Sa_avg (Eads et al. 2015), with "
        f"factors within {motions.factor_limits[0]:g} and {motions.factor_limits[1]:g}",
        "ida": "in incremental dynamic analyses (Vamvatsikos and Cornell 2002) that search for "
        f"{motions.ida_demand} = {motions.ida_threshold:g} between {low:g} and {high:g} g of "
        "Sa_avg (Eads et al. 2015)",
    }
    whole = " of the suite" if count == "All" else ""
    angle = f"at an incidence of {_listed(motions.incidence_deg)} degrees"
    if DIRECTION in config.uncertainty.drawn:
        angle = "each from a random direction"
    yield (
        f"{count} two-component ground motions{whole}{cited} act on every variant, "
        f"{scaled[motions.design]}, {angle}."
    )
    if suite is not None and "suite" in suite and suite["suite"].nunique() > 1:
        counts = suite.groupby("suite", sort=False)["motion_id"].nunique()
        listed = "; ".join(f"{name}, {count} motions" for name, count in counts.items())
        yield (
            f"They form the suites {listed}; effects are given for each suite and for all together."
        )
    if motions.shaking_s is not None:
        yield f"The strongest {motions.shaking_s:g} s of each motion are used."
    yield "Intensities are RotD50 (Boore 2010)."


def _random_properties(uncertainty: UncertaintyConfig) -> Iterator[str]:
    if not uncertainty.drawn:
        yield "No property of a bridge is random: every analysis has the values of its file."
        return
    yield (
        "Properties are drawn once per motion by Latin hypercubes of "
        f"{BLOCK} motions (Nielson and DesRoches 2007), seed {uncertainty.seed}. Every variant has "
        "the draw of the motion, so effects stay paired; the scatter of the properties is part of "
        "that between motions. Factors multiply the values of the bridge's file, offsets are added."
    )
    yield from (
        f"{property_name(name).capitalize()}: {what.as_text} ({what.source})."
        for name, what in uncertainty.drawn.items()
    )


def _analyses(config: StudyConfig) -> Iterator[str]:
    analysis = config.analysis
    integrator, cut = _INTEGRATORS[str(analysis.integrator_command[0])], ""
    if analysis.event_dt_s is not None:
        cut = f", cut to {analysis.event_dt_s:g} s where a contact opens or closes"
    yield (
        f"After gravity each response history is integrated by {integrator} with a step of "
        f"{analysis.dt_s:g} s{cut}."
    )
    yield (
        "An analysis counts as collapse when a column drift reaches "
        f"{analysis.collapse_drift_ratio:g}, the deck moves by "
        f"{analysis.collapse_deck_disp_m:g} m, or a corner leaves its seat; one that does not "
        "converge keeps its peaks as lower bounds and is never dropped."
    )


def _changed_settings(config: StudyConfig) -> Iterator[str]:
    """Yield every setting that differs from its default under the same accuracy."""
    own = config.model_dump(mode="json", exclude=_NO_METHOD)
    usual = parse_config({"accuracy": config.accuracy}).model_dump(mode="json", exclude=_NO_METHOD)
    changed = [
        f"`{section}.{key}` {_setting(value)} (default {_setting(usual[section][key])})"
        for section, values in own.items()
        for key, value in (values if isinstance(values, dict) else {}).items()
        if value != usual[section][key]
    ]
    if config.accuracy != "default":
        changed.insert(0, f"`accuracy` {config.accuracy}")
    if changed:
        yield f"Settings that differ from the defaults of the program: {'; '.join(changed)}."
    else:
        yield "All settings are the defaults of the program."


def _setting(value: object) -> str:
    if isinstance(value, list):
        return ", ".join(map(_setting, value))
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)


def _statistics(fits: FitSettings, motions: MotionsConfig) -> Iterator[str]:
    level, effect = f"{100 * fits.confidence:g} %", f"{100 * fits.effect_confidence:g} %"
    yield (
        f"Fragility functions are lognormal in {plain_label(fits.im)}. Medians and dispersions "
        "come from cloud regression (Cornell et al. 2002) with one slope for all states of a "
        "demand. Runs that collapsed or failed, and runs after the failure of a column, give a "
        "lower bound of every demand that the failure does not decide (Tobin 1958); a demand of "
        "zero gives an upper bound. A second fit by "
        "maximum likelihood uses only whether a state was exceeded (Baker 2015)."
    )
    yield (
        "The median of the cloud is used unless the two differ by more than two standard errors "
        "(Hausman 1978) and at least five runs lie on each side of the state. States that no run "
        "of a bridge reached have no curve. The loss of a column, by shear or by flexure, is a "
        "component of its own."
    )
    if motions.design in ("stripes", "ida"):
        yield f"Intervals at {level} are by jackknife over motions (Efron and Tibshirani 1993)."
    else:
        yield (
            f"Intervals at {level} are Fieller's for the regression (Fieller 1954) and profile "
            "likelihood for the other fit."
        )
    yield (
        "Effects of the axes are ratios of median capacities, with errors by jackknife over "
        "motions, and ratios of demands paired by motion (differences for rotations and abutment "
        f"deformations), both with Student's t intervals at {effect} and averaged over all pairs "
        "of variants. A regression of the paired log ratios on log intensity gives the effect at "
        "an intensity."
    )
    yield (
        f"A change within {100 * fits.margin:g} % of a demand or {100 * fits.median_margin:g} % of "
        "a median capacity is called negligible where the whole interval lies inside (Schuirmann "
        "1987). The verdicts are adjusted for the number of comparisons (Holm 1979): those of a "
        "bridge, abutment model and axis hold together, the headline demands and states as one "
        "family and the others as another."
    )


def _limit_states(config: StudyConfig) -> list[tuple[str, ...]]:
    rows: dict[str, list[LimitState]] = {}
    for state in load_limit_states(Path(config.fragility.limit_states)):
        rows.setdefault(state.component, []).append(state)
    return [
        (
            in_words(component),
            f"`{own[0].demand}`",
            ", ".join(f"{each.name} {threshold_text(each.demand, each.threshold)}" for each in own),
            _listed(sorted({each.dispersion for each in own})),
            " ".join(own[0].citation.split()),
        )
        for component, own in rows.items()
    ]


def _cited_source(source: str) -> str:
    """Return the citation of the source of the motions, or the source itself if it has none."""
    if "Dabaghi and Der Kiureghian (2018)" in source:
        return "simulated, Dabaghi and Der Kiureghian 2018"
    return source


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
