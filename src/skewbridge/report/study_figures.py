"""The figures of a study: a new one is a function of tables and a row of a table here."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from inspect import signature
from itertools import groupby, product
from operator import attrgetter
from pathlib import Path
from typing import Final

from joblib import Parallel, delayed
from matplotlib.figure import Figure

from skewbridge.motions.prepared import read_suite
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.choice_figures import tornado
from skewbridge.report.figure_cases import (
    CHOICES,
    CLOUDS,
    CURVES,
    EFFECTS,
    HISTORIES,
    MOTIONS,
    StudyTables,
    choice_cases,
    cloud_cases,
    curve_cases,
    effect_cases,
    pair_cases,
)
from skewbridge.report.figure_files import Drawing, save_figure
from skewbridge.report.fragility_effect_figures import paired_ratios, verdict_map
from skewbridge.report.fragility_figures import demand_clouds, fragility_curves
from skewbridge.report.motion_figures import applied_spectra
from skewbridge.report.pooled_effect_figure import pooled_effects
from skewbridge.report.run_figures import displacement_figure, frequency_figure, hysteresis_figure
from skewbridge.study.figure_settings import FigureSettings
from skewbridge.study.friction_pair import read_friction_pair
from skewbridge.variant.abutments import ABUTMENTS


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """What the report says of a figure.

    Attributes:
        name: File name without ending.
        section: Part of the report that it stands in, one of `figure_cases.SECTIONS`.
        title: One line.
        text: What to see and how it was made.
    """

    name: str
    section: str
    title: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyFigure(Caption):
    """A row of the tables of figures; braces in its texts hold words of a case.

    Attributes:
        draw: Draws one figure; its parameters are named as attributes of `StudyTables` or words
            of a case.
        cases: Words of each figure that the row stands for; rows in sequence with the same cases
            alternate.
    """

    draw: Callable[..., Figure]
    cases: Callable[[StudyTables], Sequence[Mapping[str, str]]] = lambda _: ({},)


#: Drawn for each bridge with each abutment model.
MODEL_FIGURES: Final = (
    StudyFigure(
        name="pooled_effects",
        section=EFFECTS,
        title="What do skew, gap and friction change, all variants together?",
        text="Average over all pairs of variants that differ in one axis only, motion by motion, "
        "in units of the margin of each demand (per cent; mm and mrad where the ratio of small "
        "numbers says little). The numbers are the changes themselves.",
        draw=pooled_effects,
        cases=lambda tables: effect_cases(tables)[:1],
    ),
    StudyFigure(
        name="verdict_{axis}",
        section=EFFECTS,
        title="When does {axis_words} matter?",
        text="Change of demand, each motion with itself. Negligible, lower, higher: the {level} "
        "interval lies within, below or above the margin ({margin}, or as said beside the demand).",
        draw=verdict_map,
        cases=effect_cases,
    ),
    StudyFigure(
        name="ratios_{axis}",
        section=EFFECTS,
        title="Paired effect of {axis_words} with {level} intervals",
        text="Student's intervals over motions. The shaded band is {margin} either "
        "way. A pair in which one run collapsed counts as a bound. Arrows with numbers lie beyond "
        "the axis. Demands that are judged by their differences stand in the map of verdicts.",
        draw=paired_ratios,
        cases=effect_cases,
    ),
    StudyFigure(
        name="curves_{component}_{method}",
        section=CURVES,
        title="Fragility of {component_words}, {method} fit",
        text="Curves have the total dispersion (record-to-record and capacity), bands are {level} "
        "of the fit; marks are the analyses. A limit state that no analysis reached has no curve.",
        draw=fragility_curves,
        cases=curve_cases,
    ),
    StudyFigure(
        name="cloud_{demand}",
        section=CLOUDS,
        title="{label} against intensity",
        text="One mark per analysis, open where its demand is a peak so far; lines are the log-log "
        "regressions.",
        draw=demand_clouds,
        cases=cloud_cases,
    ),
    StudyFigure(
        name="modelling_choices",
        section=CHOICES,
        title="Which choices of the modeller matter as much as friction?",
        text="{choice_text}",
        draw=tornado,
        cases=choice_cases,
    ),
)
#: Drawn once.
STUDY_FIGURES: Final = (
    StudyFigure(
        name="hysteresis",
        section=HISTORIES,
        title="Abutment without and with friction: {place}",
        text="Left abutment: all that it does to the deck (backwall, keys and pads) along and "
        "across the bridge, the pads alone, and the normal contact forces of backwall and shear "
        "keys alone, against the displacement of the deck end.",
        draw=hysteresis_figure,
        cases=pair_cases,
    ),
    StudyFigure(
        name="displacement",
        section=HISTORIES,
        title="Deck without and with friction: {place}",
        text="Displacement and rotation at the mass centre, relative to the ground.",
        draw=displacement_figure,
        cases=pair_cases,
    ),
    StudyFigure(
        name="frequency",
        section=HISTORIES,
        title="Frequency content without and with friction: {place}",
        text="Smoothed Fourier amplitudes of the deck and their ratio.",
        draw=frequency_figure,
        cases=pair_cases,
    ),
    StudyFigure(
        name="suite_spectra",
        section=MOTIONS,
        title="Response spectra of the motions",
        text="RotD50, 5 % damping, scaled: one factor per motion, the same for all variants.",
        draw=applied_spectra,
    ),
)


def draw_study(
    paths: Mapping[str, Path],
    *,
    folder: Path,
    captions: Path,
    settings: FigureSettings,
    choices: Path | None = None,
    n_jobs: int = 1,
) -> None:
    """Draw all figures of a study as SVG and PNG, and write their captions.

    Args:
        paths: Files by name: demands, curves, effects, suite, friction_pair.
        folder: Where the figures go.
        captions: JSON file of what the report says of them.
        settings: Width and font.
        choices: Table of modelling choices, where there is one.
        n_jobs: Processes that draw.
    """
    folder.mkdir(parents=True, exist_ok=True)
    figures = list(study_figures(read_tables(paths, choices)))
    Parallel(n_jobs=n_jobs, backend="loky")(
        delayed(save_figure)(draw, settings, folder, caption.name) for caption, draw in figures
    )
    said = {"figures": [asdict(caption) for caption, _ in figures]}
    write_text(captions, json.dumps(said, indent=1))


def read_tables(paths: Mapping[str, Path], choices: Path | None = None) -> StudyTables:
    """Read what the figures of a study are drawn from.

    Args:
        paths: Files by name: demands, curves, effects, suite, friction_pair.
        choices: Table of modelling choices, where there is one.
    """
    return StudyTables(
        **{name: read_frame(paths[name]) for name in ("demands", "curves", "effects")},
        suite=read_suite(paths["suite"]),
        pair=read_friction_pair(paths["friction_pair"]),
        choices=None if choices is None else read_frame(choices),
    )


def read_captions(path: Path) -> list[Caption]:
    """Return the captions of the figures of a study, in their order."""
    return [Caption(**item) for item in json.loads(path.read_text("utf-8"))["figures"]]


def study_figures(tables: StudyTables) -> Iterator[tuple[Caption, Drawing]]:
    """Yield every caption of a study with what draws its figure.

    Those of each bridge and abutment come first.
    """
    models = tables.demands[["bridge", "abutment"]].drop_duplicates().itertuples(index=False)
    for bridge, abutment in sorted(models):
        start = f"{bridge}_{ABUTMENTS[abutment].code}_"
        title = f"{bridge}, {abutment.replace('_', '-')}: "
        for caption, draw in _drawings(MODEL_FIGURES, tables.of_model(bridge, abutment)):
            yield replace(caption, name=start + caption.name, title=title + caption.title), draw
    yield from _drawings(STUDY_FIGURES, tables)


def _drawings(
    figures: Sequence[StudyFigure], tables: StudyTables
) -> Iterator[tuple[Caption, Drawing]]:
    for cases, group in groupby(figures, attrgetter("cases")):
        for words, row in product(cases(tables), list(group)):
            texts = {"name": row.name, "title": row.title, "text": row.text}
            said = {part: text.format_map(words) for part, text in texts.items()}
            caption = Caption(section=row.section, **said)
            needs = signature(row.draw).parameters
            given = {name: words.get(name, getattr(tables, name, None)) for name in needs}
            yield caption, partial(row.draw, **given)
