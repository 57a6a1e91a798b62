"""The methods of a study in the words of a paper, with citations, made from its configuration."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState, load_limit_states
from skewbridge.motions.settings import MotionsConfig
from skewbridge.report.html.statements import plain_label
from skewbridge.report.references import REFERENCES
from skewbridge.study.config import StudyConfig
from skewbridge.variant.axes import axis
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.options import ModelOptions

_ABUTMENTS: Final = {
    "roller": "on rollers",
    "simplified": "as one bilinear spring with a gap at each corner of the deck",
    "spring": "as elastomeric pads, backfill springs behind the joint gap and exterior shear keys, "
    "without contact",
    "contact": "as elastomeric pads, backfill and exterior shear keys that the deck meets in "
    "frictionless contact",
    "contact_friction": "as elastomeric pads, backfill and exterior shear keys that the deck meets "
    "in contact with Coulomb friction",
}
#: Heads of the table of limit states.
STATE_HEADS: Final = ("component", "demand", "median", "dispersion", "source")
_CONTACT: Final = (
    "Contact is a normal penalty spring behind a gap, with tangential elastic-plastic springs "
    "whose yield force is updated during the analysis by the normal force (Rahman and Mackie 2023; "
    "Rahman and Mackie)"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Methods:
    """The methods of a study as a paper describes them.

    Attributes:
        parts: Paragraphs by their subject.
        states: Rows of the limit states: component, demand, medians, dispersion, source.
        references: The works that the paragraphs cite, in full, sorted.
    """

    parts: Mapping[str, str]
    states: Sequence[Sequence[str]]
    references: Sequence[str]

    def markdown(self) -> str:
        """Return the whole as a page of Markdown."""
        said = "\n".join(f"**{name}.** {text}\n" for name, text in self.parts.items())
        rows = [" | ".join(cell.replace("|", "/") for cell in row) for row in self.states]
        rules = " | ".join("---" for _ in STATE_HEADS)
        table = "\n".join(f"| {row} |" for row in (" | ".join(STATE_HEADS), rules, *rows))
        listed = "\n".join(f"- {work}" for work in self.references)
        return f"# Methods\n\n{said}\n## Limit states\n\n{table}\n\n## References\n\n{listed}\n"


def methods_of(config: StudyConfig, suite: pd.DataFrame | None = None) -> Methods:
    """Return paragraphs on models, motions, analyses and statistics, and the references in them.

    A reader fills in what a configuration does not know, the site and the purpose.

    Args:
        config: The study.
        suite: Its motions as prepared, which say where they come from; None before.

    Raises:
        InputError: A bridge or the limit states of the study cannot be read.
    """
    sources = [] if suite is None else list(dict.fromkeys(suite["source"].astype(str)))
    bridges = [load_bridge(name) for name in config.grid.bridge]
    told = {
        "Bridges": _bridges(bridges, config.analysis.model_options(config.model)),
        "Abutments": _abutments(config),
        "Ground motions": _motions(config.motions, "; ".join(filter(None, sources))),
        "Analyses": _analyses(config),
        "Statistics": _statistics(config.fragility, config.motions),
    }
    parts = {name: " ".join(sentences) for name, sentences in told.items()}
    states = _limit_states(config)
    text = " ".join([*parts.values(), *chain(*states)])
    cited = sorted(key for key in REFERENCES if re.search(rf"{re.escape(key)}(?! \d)", text))
    return Methods(parts=parts, states=states, references=[REFERENCES[key] for key in cited])


def _bridges(bridges: Sequence[BridgeData], model: ModelOptions) -> Iterator[str]:
    several = len(bridges) > 1
    facts = "; ".join(
        f"{bridge.title}: {_count(len(bridge.spans_m), 'span')}, {bridge.length_m:.1f} m, "
        f"{bridge.base} column bases, T1 = {bridge.t1_s:.3g} s"
        for bridge in bridges
    )
    yield (
        f"{_count(len(bridges), 'bridge').capitalize()} {'were' if several else 'was'} modelled in "
        f"OpenSees (McKenna et al. 2010) through OpenSeesPy {version('openseespy')} (Zhu et al. "
        f"2018) with skewbridge {version('skewbridge')} ({facts})."
    )
    if any(bridge.details == "surrogate" for bridge in bridges):
        yield (
            "Details that are not public (deck section, reinforcement, abutments) are surrogates; "
            "the source of every number stands in the file of the bridge."
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
    else:
        columns = (
            "The columns are force-based fiber elements with distributed plasticity (five Lobatto "
            "points) and Mander's concrete (Mander et al. 1988)."
        )
    deck = _count(model.deck_elements_per_span, "element")
    yield f"The deck is an elastic spine of {deck} per span. {columns}"
    if model.shear_model == "sdc":
        yield "Column shear capacity follows the Caltrans criteria (Caltrans 2013)."
    else:
        yield "Column shear capacity is the revised UCSD model (Kowalsky and Priestley 2000)."
    if model.shear_failure == "flag":
        yield "A column that reaches it is marked; the analysis counts as beyond the model then."
    else:
        yield "A column that reaches it loses its shear strength."
    ratios = sorted({model.damping_ratio or bridge.damping.ratio for bridge in bridges})
    shown = " and ".join(f"{100 * ratio:g} %" for ratio in ratios)
    yield f"Rayleigh damping of deck and columns is {shown} of critical at two periods."
    bases = "rigid ground" if model.foundation == "fixed" else "foundation springs"
    yield f"Column bases stand on {bases}."


def _abutments(config: StudyConfig) -> Iterator[str]:
    names = list(config.grid.abutment)
    yield f"The seat-type abutments are modelled {'; '.join(_ABUTMENTS[name] for name in names)}."
    model = config.analysis.model_options(config.model)
    if any(name.startswith("contact") for name in names):
        update = "predicted at the end of each step"
        if model.coupling == "lagged":
            update = "of the last committed step"
        points = _count(model.backwall_points, "point")
        yield f"{_CONTACT}, {update}; {points} lie along each backwall."
    if model.backfill == "sdc" and names != ["roller"]:
        yield "The backfill is bilinear (Caltrans 2019)."
    elif any(name not in ("roller", "simplified") for name in names):
        yield "The backfill is hyperbolic."
    axes = "; ".join(
        f"{axis(name).title} {_listed(values)} {axis(name).unit}".removesuffix(" -")
        for name, values in config.grid.values().items()
    )
    count = len(expand_grid(config.grid))
    way = "normal to the backwall" if model.gap_measured == "normal" else "along the bridge"
    yield (
        f"The study crosses {axes}: {_count(count, 'variant')}. The gap is the opening of the "
        f"joint at rest, {way}."
    )


def _motions(motions: MotionsConfig, source: str) -> Iterator[str]:
    count = "All" if motions.count is None else f"{motions.count}"
    known = f" ({_cited_source(source)})" if source else ""
    low, high = motions.level_range_g
    scaled = {
        "scaled_cloud": f"each with one factor, the same for all bridges and variants, so that "
        f"Sa_avg (Eads et al. 2015) spans {low:g} to {high:g} g",
        "cloud": "unscaled",
        "stripes": f"scaled to {_listed(motions.stripes_g)} g of Sa_avg (Eads et al. 2015), with "
        f"factors within {motions.factor_limits[0]:g} and {motions.factor_limits[1]:g}",
        "ida": "in incremental dynamic analyses (Vamvatsikos and Cornell 2002) that search for "
        f"{motions.ida_demand} = {motions.ida_threshold:g} between {low:g} and {high:g} g of "
        "Sa_avg (Eads et al. 2015)",
    }
    suite = " of the suite" if motions.count is None else ""
    yield (
        f"{count} two-component ground motions{suite}{known} act on every variant, "
        f"{scaled[motions.design]}, at an incidence of {_listed(motions.incidence_deg)} degrees."
    )
    if motions.shaking_s is not None:
        yield f"The strongest {motions.shaking_s:g} s of each motion are used."
    yield "Intensities are RotD50 (Boore 2010)."


def _analyses(config: StudyConfig) -> Iterator[str]:
    analysis = config.analysis
    yield (
        f"After gravity each response history is integrated {_integrator(analysis)} with a step of "
        f"{analysis.dt_s:g} s"
        + (
            f", cut to {analysis.event_dt_s:g} s where a contact opens or closes."
            if analysis.event_dt_s is not None
            else "."
        )
    )
    yield (
        "An analysis counts as collapse when a column drift reaches "
        f"{analysis.collapse_drift_ratio:g}, the deck moves by "
        f"{analysis.collapse_deck_disp_m:g} m, or a corner leaves its seat; one that does not "
        "converge keeps its peaks as lower bounds and is never dropped."
    )


def _integrator(analysis: AnalysisSettings) -> str:
    name = str(analysis.integrator_command[0])
    cited = {
        "Newmark": "Newmark's method (Newmark 1959)",
        "Houbolt": "Houbolt's method (Houbolt 1950)",
        "HHT": "the HHT method (Hilber et al. 1977)",
    }
    return f"by {cited[name]}"


def _statistics(fits: FitSettings, motions: MotionsConfig) -> Iterator[str]:
    level = f"{100 * fits.confidence:g} %"
    yield (
        "Fragility functions are lognormal in "
        f"{plain_label(fits.im)}. Medians and dispersions come from cloud regression (Cornell et "
        "al. 2002), in which runs that collapsed, failed or went beyond the model are censored "
        "demands (Tobin 1958), and beside it from maximum likelihood on whether a state was "
        "exceeded (Baker 2015)."
    )
    if motions.design in ("stripes", "ida"):
        yield (
            f"Intervals at {level} are by bootstrap of whole records, {fits.bootstrap} replicates "
            "(Efron and Tibshirani 1993)."
        )
    else:
        yield (
            f"Intervals at {level} are Fieller's for the regression (Fieller 1954) and profile "
            "likelihood for the other."
        )
    yield (
        "Effects of the axes are ratios of demands paired by motion (differences for rotations and "
        "abutment deformations), with Student's t intervals at "
        f"{100 * fits.effect_confidence:g} % over motions; a change within {100 * fits.margin:g} % "
        "is called negligible where the whole interval lies inside (Schuirmann 1987), and verdicts "
        "that hold together are adjusted (Holm 1979)."
    )


def _limit_states(config: StudyConfig) -> list[tuple[str, ...]]:
    rows: dict[str, list[LimitState]] = {}
    for state in load_limit_states(Path(config.fragility.limit_states)):
        rows.setdefault(state.component, []).append(state)
    return [
        (
            component.replace("_", " "),
            f"`{states[0].demand}`",
            ", ".join(f"{state.name} {state.threshold:g}" for state in states),
            _listed(sorted({state.dispersion for state in states})),
            " ".join(states[0].citation.split()),
        )
        for component, states in rows.items()
    ]


def _cited_source(source: str) -> str:
    """Return the source of the motions as it is cited, where it is a work that we know."""
    if "Dabaghi and Der Kiureghian (2018)" in source:
        return "simulated, Dabaghi and Der Kiureghian 2018"
    return source


def _count(number: int, what: str) -> str:
    words = ("no", "one", "two", "three", "four", "five", "six")
    told = words[number] if number < len(words) else f"{number}"
    return f"{told} {what}{'' if number == 1 else 's'}"


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
