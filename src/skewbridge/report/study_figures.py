"""Figures of a study: their list with captions, drawing, and files of a given width and font."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from matplotlib.figure import Figure

from skewbridge.demands.columns import label_of
from skewbridge.demands.completeness import with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.tables import figure_metadata, read_frame, records_of
from skewbridge.files.text import shortened, write_text
from skewbridge.fragility.verdicts import DECIDED, HIGHER, LOWER
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.report.answer import change_name, effect_name, listed, model_name
from skewbridge.report.axis_layout import (
    MAX_BANDS,
    VariantLayout,
    in_words,
    plain_label,
    shown_in,
    shown_unit,
    threshold_text,
    value_text,
)
from skewbridge.report.effect_figures import (
    choice_findings,
    effects_by_intensity,
    intensity_demands,
    tornado,
    tornado_text,
    widths_by_analyses,
)
from skewbridge.report.fragility_figures import (
    demand_clouds,
    fragility_curves,
    least_shown,
    pooled_ratios,
    shown_curves,
)
from skewbridge.report.motion_figures import applied_spectra
from skewbridge.report.run_figures import (
    SPECTRA,
    displacement_figure,
    frequency_figure,
    hysteresis_figure,
    mean_period_s,
    moving_columns,
)
from skewbridge.report.verdict_style import change_text, demand_name, interval_text, margin_text
from skewbridge.study.config import DESIGN_FONT_PT, GENERIC_FONTS, FigureSettings
from skewbridge.study.folder import StudyFolder
from skewbridge.study.friction_pair import FrictionPair, read_friction_pair
from skewbridge.units import INCH, MM
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import AXES

#: What figures show; the gallery of the page has them in this order.
CURVES, CLOUDS, EFFECTS, CHOICES, HISTORIES, MOTIONS = SECTIONS = (
    "fragility curves",
    "demand against intensity",
    "effects by intensity",
    "modelling choices",
    "histories",
    "motions",
)
_TABLES: Final = ("demands", "curves", "medians", "effects", "intensity_effects")
PNG_DPI: Final = 300
#: A process takes as long to start as to draw five figures.
FIGURES_OF_A_PROCESS: Final = 12
#: Font that contains all characters of the figures.
_EVERY_SIGN: Final = "DejaVu Sans"
#: Smallest share of its width at which the texts of a figure do not overlap.
_NARROWEST: Final = 0.8
_MARGIN_IN: Final = 0.1  # white margin of a figure
_SVG_SIZE: Final = re.compile(rb'(<svg [^>]*)width="([\d.]+)pt" height="([\d.]+)pt"')

type Drawing = Callable[[], Figure]


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """Text of the report about a figure.

    Attributes:
        name: File name without ending.
        section: What it shows, one of `SECTIONS`.
        title: One line.
        text: Content of the figure and its method.
        finding: What it shows in one sentence, from the tables.
        item: Component, demand or quantity of the figure.
        model: Bridge and abutment model; empty for a figure of the whole study.
    """

    name: str
    section: str
    title: str
    text: str
    finding: str
    item: str
    model: str = ""


type StudyFigure = tuple[Caption, Drawing]


@dataclass(frozen=True, kw_only=True)
class FigureTables:
    """Tables of a study that its figures are drawn from.

    Attributes:
        demands: Demands table.
        curves: Fits.
        medians: Effects on median capacities.
        effects: Effects on demands.
        intensity_effects: Effects on demands by intensity.
        suite: Motions as applied.
        pair: Histories of one bridge without and with friction; None if the study has none.
        choices: Modelling choices; None before `make choices`.
        rounds: Headline effects after each round; None of a study without rounds.
    """

    demands: pd.DataFrame
    curves: pd.DataFrame
    medians: pd.DataFrame
    effects: pd.DataFrame
    intensity_effects: pd.DataFrame
    suite: Sequence[SuiteMotion]
    pair: FrictionPair | None
    choices: pd.DataFrame | None = None
    rounds: pd.DataFrame | None = None

    def of_model(self, bridge: str, abutment: str) -> "FigureTables":
        """Return the tables of one bridge with one abutment model."""
        own = {
            name: table[(table["bridge"] == bridge) & (table["abutment"] == abutment)]
            for name, table in vars(self).items()
            if isinstance(table, pd.DataFrame)
        }
        return replace(self, **own)


def study_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    """Yield caption and drawing function of every figure, those of each bridge model first."""
    tables = replace(tables, demands=with_derived_columns(tables.demands))
    models = tables.demands[["bridge", "abutment"]].drop_duplicates().itertuples(index=False)
    for bridge, abutment in sorted(models):
        start = f"{bridge}_{ABUTMENTS[abutment].code}_"
        model = model_name(bridge, abutment)
        own = tables.of_model(bridge, abutment)
        for figures in MODEL_FIGURES:
            for caption, draw in figures(own):
                title = f"{model}: {caption.title}"
                yield replace(caption, name=start + caption.name, title=title, model=model), draw
    for figures in STUDY_FIGURES:
        yield from figures(tables)


def _intensity_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    table = tables.intensity_effects
    demands = intensity_demands(table)
    if not demands:
        return
    im = str(tables.curves["im"].iloc[0])
    reference = table[table["at_reference"]]
    inside = reference.loc[~reference["clipped"], "im"]
    dots = "" if reference.empty else "Dots are at the reference intensity"
    if len(inside):
        dots += f", {plain_label(im)} {inside.iloc[0]:.2g}"
    if reference["clipped"].any():
        dots += ", open ones at the end of the range nearest to it"
    pooled = tables.effects[tables.effects["scope"] == "pooled"]
    tests = pooled.loc[pooled["demand"].isin(demands), "p_slope"].dropna()
    dependent = int((tests < 0.05).sum())
    caption = Caption(
        name="effects_by_intensity",
        section=EFFECTS,
        item="headline demands",
        title="Effects by intensity",
        finding=f"{dependent} of {len(tests)} effects on the headline demands change with "
        "intensity (p < 0.05).",
        text="Regression of the paired log ratio on log intensity, all variants, in the range of "
        f"the pairs. The {100 * table['level'].iloc[0]:g} % bands, clustered by motion, are those "
        f"of the {MAX_BANDS} largest changes at most. {dots and dots + '.'}".strip(),
    )
    yield caption, partial(effects_by_intensity, table, label_of(im))


def _curve_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    shown = shown_curves(tables.curves)
    layout = VariantLayout.of(tables.curves)
    for component, rows in shown.groupby("component", sort=False):
        drawn = rows[rows["preferred"]]
        if drawn.empty:  # brackets alone are in the tables
            continue
        by_exceedance = int((drawn["method"] != "cloud").sum())
        differ = int(drawn["methods_differ"].sum())
        words = in_words(component)
        bands = f"; {layout.banded_text} only" if layout.banded_text else ""
        text = (
            "Curves with record-to-record and capacity dispersion: "
            f"{len(drawn) - by_exceedance} from cloud fits, {by_exceedance} from exceedances "
            f"({100 * rows['level'].iloc[0]:g} % bands{bands}). Ticks are analyses: at the top "
            "those that exceed the state, at the bottom those that do not. A bar at 0.5: no curve, "
            "the median lies inside it. At the right the paired ratios of the medians, averaged "
            "over all other axes. "
        )
        if differ:
            text += (
                f"In {differ} of {len(drawn)} the medians of both methods differ (by more than "
                "15 %, or two standard errors): an open diamond is the other median. "
            )
        text += "A limit state that no analysis reached has no curve and is listed at the top."
        caption = Caption(
            name=f"curves_{component}",
            section=CURVES,
            item=words,
            title=f"Fragility of {words}",
            finding=_median_finding(pooled_ratios(tables.medians, str(component)), words),
            text=text,
        )
        draw = partial(
            fragility_curves, tables.curves, tables.demands, tables.medians, str(component)
        )
        yield caption, draw


def _median_finding(ratios: pd.DataFrame, words: str) -> str:
    """Return the largest certain change of the medians of a component in one sentence."""
    if ratios.empty:
        return f"No two medians of {words} can be compared."
    certain = ratios[ratios["verdict_family"].isin((LOWER, HIGHER))]
    if certain.empty:
        return f"No change of these medians by over {margin_text(ratios.iloc[0])} is certain."
    row = records_of(certain)[
        int(np.abs(np.log(certain["ratio"].to_numpy(dtype=np.float64))).argmax())
    ]
    change = change_name(row["axis"], row["from_value"], row["to_value"])
    verb = "lowers" if row["ratio"] < 1.0 else "raises"
    size = change_text(row).lstrip("+-")
    return (
        f"{change} {verb} the median capacity for {effect_name(row['demand'])} by {size} "
        f"({interval_text(row)}), the largest certain change."
    )


def _cloud_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    demands, curves = tables.demands, tables.curves
    for name in dict.fromkeys(map(str, curves["demand"])):
        if name not in demands or least_shown(demands, curves, name) is None:
            continue
        early, zero = int((~demands["complete"]).sum()), int((demands[name] == 0.0).sum())
        text = f"One mark for each of {len(demands)} analyses; lines are the fits. "
        if early:
            text += (
                f"{early} open marks with a tick upward: the analysis ended early, by collapse or "
                "failure of a column, so the demand is a lower bound. "
            )
        if zero:
            text += f"{zero} demands are zero and drawn at the bottom."
        mildest = curves[curves["demand"] == name].sort_values("threshold").iloc[0]
        above = int((demands[name] > mildest["threshold"]).sum())
        state = in_words(f"{mildest['component']}, {mildest['limit_state']}")
        caption = Caption(
            name=f"cloud_{name}",
            section=CLOUDS,
            item=demand_name(name),
            title=f"{demand_name(name)} against intensity",
            finding=f"{above} of {len(demands)} analyses exceed {state} "
            f"({threshold_text(name, float(mildest['threshold']))}).",
            text=text.strip(),
        )
        yield caption, partial(demand_clouds, demands, curves, name)


def _choice_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    if tables.choices is None or tables.choices.empty:
        return
    findings = choice_findings(tables.choices)
    caption = Caption(
        name="modelling_choices",
        section=CHOICES,
        item="headline demands",
        title="Modelling choices compared with friction, gap and skew",
        finding=findings[0] if findings else "No choice can be compared with friction.",
        text=tornado_text(tables.choices),
    )
    yield caption, partial(tornado, tables.choices)


def _round_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    if tables.rounds is None or tables.rounds.empty:
        return
    demands = tables.demands
    last = tables.rounds[tables.rounds["round"] == tables.rounds["round"].max()]
    decided, analyses = int(last["verdict"].isin(DECIDED).sum()), len(demands)
    angles = demands["incidence_deg"].nunique()
    full = demands["variant"].nunique() * len(tables.suite) * angles
    motions = len({each.motion.motion_id for each in tables.suite})
    caption = Caption(
        name="rounds",
        section=EFFECTS,
        item="headline effects",
        title="Rounds of the study",
        finding=f"{decided} of {len(last)} headline effects are decided after {analyses} analyses; "
        f"all {motions} motions for every variant are {full} analyses "
        f"(saved: {100 * (1 - analyses / full):.0f} %).",
        text="Half-width of the interval of each pooled headline effect after every round, with a "
        "dot at the round of its verdict; lines without a dot are open. All intervals of an effect "
        "hold together, so that a verdict keeps its error probability when the study stops.",
    )
    yield caption, partial(widths_by_analyses, tables.rounds)


def _history_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    if tables.pair is None:
        return
    variant, runs = tables.pair.variants[0], tables.pair.by_friction
    skew, gap = (value_text(axis, variant.values()[axis.name]) for axis in AXES[:2])
    name = f"without and with friction: {variant.bridge_name}, skew {skew}, gap {gap}, motion "
    name += tables.pair.motion_id
    yield (
        Caption(
            name="hysteresis",
            section=HISTORIES,
            item="abutment forces",
            title=f"Abutment {name}",
            finding=_peaks("Largest longitudinal force of the left abutment", runs,
                           "abutment_left_x_kn", "kN"),
            text="Forces of the left abutment on the deck (backwall, keys and pads) along and "
            "across the bridge, of the pads alone, and normal contact forces of backwall and shear "
            "keys alone, against the displacement of the deck end.",
        ),
        partial(hysteresis_figure, runs),
    )  # fmt: skip
    yield (
        Caption(
            name="displacement",
            section=HISTORIES,
            item="deck displacement",
            title=f"Deck {name}",
            finding=_peaks("Largest longitudinal displacement", runs, "deck_ux_m", "m"),
            text="Displacement and rotation at the mass centre, relative to the ground.",
        ),
        partial(displacement_figure, runs),
    )
    if moving := moving_columns(runs):
        periods = listed(f"{mean_period_s(table, moving[0]):.2f} s" for table in runs.values())
        yield (
            Caption(
                name="frequency",
                section=HISTORIES,
                item="frequency content",
                title=f"Frequency content {name}",
                finding=f"Mean period of the {SPECTRA[moving[0]].split(' (')[0]} motion of the "
                f"deck: {periods} with {listed(runs)}.",
                text="Smoothed Fourier amplitudes of the deck and their ratio.",
            ),
            partial(frequency_figure, runs),
        )


def _peaks(what: str, runs: Mapping[str, pd.DataFrame], column: str, unit: str) -> str:
    """Return the largest absolute value of a column in each run as a sentence."""
    shown, factor = shown_unit(unit)
    peaks = [f"{factor * table[column].abs().max():.3g} {shown}" for table in runs.values()]
    return f"{what}: {listed(peaks)} with {listed(runs)}."


def _motion_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    if not tables.suite:
        return
    scales = [item.scale for item in tables.suite]
    caption = Caption(
        name="suite_spectra",
        section=MOTIONS,
        item="response spectra",
        title="Response spectra of the motions",
        finding=f"{len(scales)} motions with factors from {min(scales):.2g} to {max(scales):.2g}.",
        text="RotD50, 5 % damping, scaled: one factor per motion, the same for all variants.",
    )
    yield caption, partial(applied_spectra, tables.suite)


type Figures = Callable[[FigureTables], Iterator[StudyFigure]]
#: Drawn for each bridge with each abutment model.
MODEL_FIGURES: Final[tuple[Figures, ...]] = (
    _curve_figures,
    _cloud_figures,
    _intensity_figures,
    _choice_figures,
)
#: Drawn once.
STUDY_FIGURES: Final[tuple[Figures, ...]] = (_round_figures, _history_figures, _motion_figures)


def read_tables(paths: Mapping[str, Path], choices: Path | None = None) -> FigureTables:
    """Read the tables that the figures of a study are drawn from.

    Args:
        paths: Files by name: demands, curves, medians, effects, intensity_effects, suite,
            friction_pair; rounds where the study has them.
        choices: Table of modelling choices, if there is one.
    """
    return FigureTables(
        **{name: read_frame(paths[name]) for name in _TABLES},
        suite=read_suite(paths["suite"]),
        pair=read_friction_pair(paths["friction_pair"]),
        choices=None if choices is None else read_frame(choices),
        rounds=read_frame(paths["rounds"]) if "rounds" in paths else None,
    )


def read_captions(path: Path) -> list[Caption]:
    """Return the captions of the figures of a study, in their order."""
    return [Caption(**item) for item in json.loads(path.read_text("utf-8"))["figures"]]


def draw_study(
    paths: Mapping[str, Path],
    *,
    folder: Path,
    captions: Path,
    settings: FigureSettings,
    choices: Path | None = None,
    provenance: Mapping[str, str] | None = None,
    n_jobs: int = 1,
) -> None:
    """Draw all figures of a study as SVG and PNG, and write their captions.

    Args:
        paths: Files by name, as for `read_tables`.
        folder: Folder of the figures.
        captions: JSON file of the captions.
        settings: Width and font.
        choices: Table of modelling choices, if there is one.
        provenance: Texts by name, kept in the metadata of the figures.
        n_jobs: Largest number of processes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with shown_in(settings.units):
        figures = list(study_figures(read_tables(paths, choices)))
    n_jobs = min(n_jobs, max(1, len(figures) // FIGURES_OF_A_PROCESS))
    Parallel(n_jobs=n_jobs, backend="loky")(
        delayed(save_figure)(draw, settings, folder, caption.name, provenance)
        for caption, draw in figures
    )
    texts = {"figures": [asdict(caption) for caption, _ in figures]}
    write_text(captions, json.dumps(texts, indent=1))


def finished_figures(results: Path) -> list[StudyFigure]:
    """Return the figures of a finished study; none is drawn yet.

    Args:
        results: Folder of the study.

    Raises:
        InputError: A table is missing.
    """
    folder = StudyFolder(results)
    paths = {
        "demands": folder.demands,
        "curves": folder.fragility("curves"),
        "medians": folder.fragility("median_effects"),
        "effects": folder.fragility("effects"),
        "intensity_effects": folder.fragility("intensity_effects"),
        "suite": folder.suite,
        "friction_pair": folder.friction_pair,
    }
    for path in paths.values():
        if not path.is_file():
            raise InputError(f"{path} is missing: finish the study first", file=str(path))
    if folder.rounds.is_file():
        paths["rounds"] = folder.rounds
    choices = folder.modelling_choices if folder.modelling_choices.is_file() else None
    return list(study_figures(read_tables(paths, choices)))


def draw_figures(
    figures: Sequence[StudyFigure], names: Sequence[str], settings: FigureSettings, folder: Path
) -> list[Path]:
    """Draw the named figures of a study as SVG and PNG.

    Args:
        figures: All figures of the study.
        names: Names of figures, with ``*`` for any text.
        settings: Width and font.
        folder: Folder of the files.

    Returns:
        The files.

    Raises:
        InputError: A name fits no figure; nothing is drawn then.
    """
    known = [caption.name for caption, _ in figures]
    for name in names:
        if not any(fnmatchcase(each, name) for each in known):
            like = get_close_matches(name, known, n=3) or known[:3]
            text = f"unknown figure {shortened(name)}; similar names: {', '.join(like)}"
            raise InputError(f"{text}; `skewbridge study plot` lists all figures")
    return [
        path
        for caption, draw in figures
        if any(fnmatchcase(caption.name, name) for name in names)
        for path in save_figure(draw, settings, folder, caption.name)
    ]


def save_figure(
    draw: Drawing,
    settings: FigureSettings,
    folder: Path,
    name: str,
    provenance: Mapping[str, str] | None = None,
) -> list[Path]:
    """Draw a figure and write it as SVG, with texts as texts, and as PNG.

    Another font size, or a width too small for its columns, enlarges or reduces the figure as a
    whole, so that its parts keep their positions.

    Args:
        draw: Function that draws it.
        settings: Width and font.
        folder: Folder of the files.
        name: File name without ending.
        provenance: Texts by name, kept in the metadata of both files.

    Returns:
        The two files.
    """
    vector_path, path = (folder / f"{name}.{ending}" for ending in ("svg", "png"))
    with mpl.rc_context(_rc(settings)), shown_in(settings.units):
        figure = draw()
        scale = _fit(figure, settings)
        if layout := figure.get_layout_engine():  # once, for both files
            layout.execute(figure)
            figure.set_layout_engine("none")
        tight: Any = {}
        if settings.width_mm is None:
            tight = {"bbox_inches": figure.get_tightbbox().padded(_MARGIN_IN)}
        vector = BytesIO()
        metadata: dict[str, str] = figure_metadata(provenance) if provenance else {}
        figure.savefig(vector, format="svg", metadata={**metadata, "Date": None}, **tight)
        vector_path.write_bytes(_scaled_svg(vector.getvalue(), scale))
        # strong compression takes half of the time of a figure and saves a seventh of its file
        printed = {"dpi": (PNG_DPI, PNG_DPI), "compress_level": 1}
        dpi = PNG_DPI * scale
        figure.savefig(path, dpi=dpi, metadata=metadata, pil_kwargs=printed, **tight)
    return [vector_path, path]


def _rc(settings: FigureSettings) -> Any:
    font = settings.font
    # names of parts by their content, so that equal figures are equal files
    chosen: dict[str, Any] = {"svg.fonttype": "none", "svg.hashsalt": "skewbridge"}
    if font == "sans-serif":
        return chosen
    chosen["font.family"] = [font, _EVERY_SIGN]
    if font == "serif":
        chosen["mathtext.fontset"] = "dejavuserif"
    elif font not in GENERIC_FONTS:
        italic, bold = f"{font}:italic", f"{font}:bold"
        chosen |= {"mathtext.fontset": "custom", "mathtext.rm": font, "mathtext.cal": font}
        chosen |= {"mathtext.it": italic, "mathtext.bf": bold}
    return chosen


def _fit(figure: Figure, settings: FigureSettings) -> float:
    """Set the width of a figure; return the factor by which its file must be enlarged."""
    scale = settings.font_size_pt / DESIGN_FONT_PT
    if settings.width_mm is None:
        return scale
    width_in = settings.width_mm * MM / INCH
    own_in, height_in = figure.get_size_inches()
    laid_out_in = max(width_in / scale, _NARROWEST * own_in)
    figure.set_size_inches(laid_out_in, height_in)
    return width_in / laid_out_in


def _scaled_svg(source: bytes, scale: float) -> bytes:
    """Return a drawing with another size on paper and the same view box."""
    if scale == 1.0:
        return source

    def enlarged(found: re.Match[bytes]) -> bytes:
        width, height = (scale * float(size) for size in found.groups()[1:])
        return found[1] + f'width="{width:.6g}pt" height="{height:.6g}pt"'.encode()

    return _SVG_SIZE.sub(enlarged, source, count=1)
