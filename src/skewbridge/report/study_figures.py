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
from skewbridge.demands.validity import with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.tables import figure_metadata, read_frame, records_of
from skewbridge.files.text import shortened, write_text
from skewbridge.fragility.verdicts import DECIDED, HIGHER, LOWER
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.report.answer import change_name, effect_name, listed, model_name, number
from skewbridge.report.axis_layout import (
    MAX_BANDS,
    MAX_SHOWN_RUNS,
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
    median_notes,
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
from skewbridge.study.repeats import read_friction_pair
from skewbridge.units import INCH, MM
from skewbridge.variant.axes import AXES
from skewbridge.variant.variant import ABUTMENTS, Variant

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
_SANS_SERIF: Final = [_EVERY_SIGN, "Verdana"]  # as wide, for SVG where the first is missing
#: Smallest share of its width at which the texts of a figure do not overlap.
_NARROWEST: Final = 0.8
_MARGIN_IN: Final = 0.1  # white margin of a figure
_SVG_SIZE: Final = re.compile(rb'(<svg [^>]*)width="([\d.]+)pt" height="([\d.]+)pt"')

type Drawing = Callable[[], Figure]


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """Text of the report about a figure."""

    name: str  # of the file, without ending
    section: str  # one of `SECTIONS`
    title: str
    text: str  # content of the figure and its method
    finding: str  # what it shows in one sentence, from the tables
    item: str  # component, demand or quantity
    model: str = ""  # bridge and abutment model; empty for a figure of the whole study


type StudyFigure = tuple[Caption, Drawing]


@dataclass(frozen=True, kw_only=True)
class FigureTables:
    """Tables of a study that its figures are drawn from."""

    demands: pd.DataFrame
    curves: pd.DataFrame
    medians: pd.DataFrame  # effects on median capacities
    effects: pd.DataFrame  # effects on demands
    intensity_effects: pd.DataFrame
    suite: Sequence[SuiteMotion]
    pair: tuple[Variant, str, dict[str, pd.DataFrame]] | None  # see `read_friction_pair`
    choices: pd.DataFrame | None = None  # None before `make choices`
    rounds: pd.DataFrame | None = None  # headline effects after each round

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
    dots = ""
    if len(reference):
        inside = reference.loc[~reference["clipped"], "im"].head(1)
        dots = " Dots are at the reference intensity"
        dots += "".join(f", {plain_label(im)} {value:.2g}" for value in inside)
        if reference["clipped"].any():
            dots += ", open ones at the end of the range nearest to it"
        dots += "."
    pooled = tables.effects[tables.effects["scope"] == "pooled"]
    tests = pooled.loc[pooled["demand"].isin(demands), "p_slope"].dropna()
    caption = Caption(
        name="effects_by_intensity",
        section=EFFECTS,
        item="headline demands",
        title="Effects by intensity",
        finding=f"{(tests < 0.05).sum()} of {len(tests)} effects on the headline demands change "
        "with intensity (p < 0.05).",
        text="Regression of the paired log ratio on log intensity, all variants, in the range of "
        f"the pairs. The {100 * table['level'].iloc[0]:g} % bands, clustered by motion, are those "
        f"of the {MAX_BANDS} largest changes at most.{dots}",
    )
    yield caption, partial(effects_by_intensity, table, label_of(im))


def _curve_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    shown = shown_curves(tables.curves)
    layout = VariantLayout.of(tables.curves)
    bands = f"; {layout.banded_text} only" if layout.banded_text else ""
    for component, rows in shown.groupby("component", sort=False):
        drawn = rows[rows["preferred"]]
        if drawn.empty:  # brackets alone are in the tables
            continue
        words, by_cloud = in_words(component), int((drawn["method"] == "cloud").sum())
        ratios = pooled_ratios(tables.medians, str(component))
        crossed = by_cloud < len(drawn)
        text = (
            f"Curves with record-to-record and capacity dispersion, {by_cloud} from cloud fits and "
            f"{len(drawn) - by_cloud} from exceedances{', with crosses' if crossed else ''} "
            f"({100 * rows['level'].iloc[0]:g} % bands{bands}). Ticks are analyses: at the top "
            "those that exceed the state, at the bottom those that do not. "
        )
        if len(drawn) < len(rows):
            text += "A bar at 0.5: no curve, the median lies inside it. "
        text += (
            "At the right the paired ratios of the medians of the cloud fits, averaged over all "
            "other axes"
        )
        notes = median_notes(ratios)
        text += (
            f" (some medians: {', '.join(notes)}; a median without a curve is that of its cloud "
            "fit, and runs that ended early leave it too uncertain). "
            if notes
            else ". "
        )
        if differ := int(drawn["methods_differ"].sum()):
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
            finding=_median_finding(ratios, words),
            text=text,
        )
        given = tables.curves, tables.demands, tables.medians, str(component)
        yield caption, partial(fragility_curves, *given)


def _median_finding(ratios: pd.DataFrame, words: str) -> str:
    """Return the largest certain change of the medians of a component in one sentence."""
    if ratios.empty:
        return f"No two medians of {words} can be compared."
    certain = records_of(ratios[ratios["verdict_family"].isin((LOWER, HIGHER))])
    if not certain:
        return f"No change of these medians by over {margin_text(ratios.iloc[0])} is certain."
    row = max(certain, key=lambda each: abs(np.log(each["ratio"])))
    change = change_name(row["axis"], row["from_value"], row["to_value"])
    verb, size = "lowers" if row["ratio"] < 1.0 else "raises", change_text(row).lstrip("+-")
    return (
        f"{change} {verb} the median capacity for {effect_name(row['demand'])} by {size} "
        f"({interval_text(row)}), the largest certain change."
    )


def _cloud_figures(tables: FigureTables) -> Iterator[StudyFigure]:
    demands, curves = tables.demands, tables.curves
    for name in dict.fromkeys(map(str, curves["demand"])):
        least = least_shown(demands, curves, name) if name in demands else None
        if least is None:
            continue
        known = demands[demands[name].notna()]
        early = int((~known["complete"]).sum())
        below = int((known["complete"] & (known[name] < least)).sum())
        text = f"One mark for each of {len(known)} analyses; lines are the fits. "
        if len(demands) > MAX_SHOWN_RUNS:
            text = "Marks are the analyses that the first line counts; lines are the fits of all. "
        if early:
            text += (
                f"{early} analyses (open marks with a tick upward) ended early, by collapse or "
                "failure of a column, so the demand is a lower bound. "
            )
        if below:
            limit = threshold_text(name, least)
            text += f"{below} demands are zero or below {limit} and drawn at the bottom."
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
    variant, motion_id, runs = tables.pair
    skew, gap = (value_text(axis, variant.values()[axis.name]) for axis in AXES[:2])
    place = f"{variant.bridge_name}, skew {skew}, gap {gap}, motion {motion_id}"
    pair = f"without and with friction: {place}"
    yield (
        Caption(
            name="hysteresis",
            section=HISTORIES,
            item="abutment forces",
            title=f"Abutment {pair}",
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
            title=f"Deck {pair}",
            finding=_peaks("Largest longitudinal displacement", runs, "deck_ux_m", "m"),
            text="Displacement and rotation at the mass centre, relative to the ground.",
        ),
        partial(displacement_figure, runs),
    )
    for column in moving_columns(runs)[:1]:
        periods = listed(f"{mean_period_s(table, column):.2f} s" for table in runs.values())
        caption = Caption(
            name="frequency",
            section=HISTORIES,
            item="frequency content",
            title=f"Frequency content {pair}",
            finding=f"Mean period of the {SPECTRA[column].split(' (')[0]} motion of the deck: "
            f"{periods} with {listed(runs)}.",
            text="Smoothed Fourier amplitudes of the deck and their ratio.",
        )
        yield caption, partial(frequency_figure, runs)


def _peaks(what: str, runs: Mapping[str, pd.DataFrame], column: str, unit: str) -> str:
    """Return the largest absolute value of a column in each run as a sentence."""
    shown, factor = shown_unit(unit)
    peaks = [f"{number(factor * table[column].abs().max())} {shown}" for table in runs.values()]
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

    ``paths`` are files by name: `_TABLES`, suite, friction_pair, and rounds of a study in rounds.
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

    ``paths`` and ``choices`` are those of `read_tables`; the figures keep ``provenance`` in their
    metadata.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with shown_in(settings.units):
        figures = list(study_figures(read_tables(paths, choices)))
    n_jobs = min(n_jobs, max(1, len(figures) // FIGURES_OF_A_PROCESS))
    # the quickest last, so that all processes end together
    ordered = sorted(figures, key=lambda figure: figure[0].section == CLOUDS)
    Parallel(n_jobs=n_jobs, backend="loky")(
        delayed(save_figure)(draw, settings, folder, caption.name, provenance)
        for caption, draw in ordered
    )
    write_text(captions, json.dumps({"figures": [asdict(each) for each, _ in figures]}, indent=1))


def finished_figures(results: Path) -> list[StudyFigure]:
    """Return the figures of a finished study in a folder; none is drawn yet.

    Raises:
        InputError: A table is missing.
    """
    folder = StudyFolder(results)
    paths = folder.report_inputs | {"friction_pair": folder.friction_pair}
    for path in (paths[name] for name in (*_TABLES, "suite", "friction_pair")):
        if not path.is_file():
            raise InputError(f"{path} is missing: finish the study first", file=str(path))
    if folder.rounds.is_file():
        paths["rounds"] = folder.rounds
    choices = folder.modelling_choices if folder.modelling_choices.is_file() else None
    return list(study_figures(read_tables(paths, choices)))


def draw_figures(
    figures: Sequence[StudyFigure], names: Sequence[str], settings: FigureSettings, folder: Path
) -> list[Path]:
    """Draw the named figures of a study as SVG and PNG, with ``*`` for any text; return the files.

    Raises:
        InputError: A name fits no figure; nothing is drawn then.
    """
    drawings = {caption.name: draw for caption, draw in figures}
    chosen: dict[str, Drawing] = {}
    for name in names:
        if not (matching := [each for each in drawings if fnmatchcase(each, name)]):
            like = get_close_matches(name, drawings, n=3) or list(drawings)[:3]
            text = f"unknown figure {shortened(name)}; similar names: {', '.join(like)}"
            raise InputError(f"{text}; `skewbridge study plot` lists all figures")
        chosen |= {each: drawings[each] for each in matching}
    files = (save_figure(draw, settings, folder, name) for name, draw in chosen.items())
    return [path for pair in files for path in pair]


def save_figure(
    draw: Drawing,
    settings: FigureSettings,
    folder: Path,
    name: str,
    provenance: Mapping[str, str] | None = None,
) -> list[Path]:
    """Draw a figure and write it as SVG, with texts as texts, and as PNG.

    Another font size, or a width too small for its columns, enlarges or reduces the figure as a
    whole, so that its parts keep their positions. Both files keep ``provenance`` in their metadata.
    """
    vector_path, path = (folder / f"{name}.{ending}" for ending in ("svg", "png"))
    metadata = figure_metadata(provenance) if provenance else {}
    with mpl.rc_context(_rc(settings)), shown_in(settings.units):
        figure = draw()
        scale = _fit(figure, settings)
        for spine in (each for axes in figure.axes for each in axes.spines.values()):
            spine.set_in_layout(False)  # the labels reach further, and its extent costs a third
        if layout := figure.get_layout_engine():  # once, for both files
            layout.execute(figure)
            figure.set_layout_engine(None)  # with any other, "none" too, saving draws twice
        box = None if settings.width_mm else figure.get_tightbbox().padded(_MARGIN_IN)
        vector = BytesIO()
        figure.savefig(vector, format="svg", metadata=metadata | {"Date": None}, bbox_inches=box)
        vector_path.write_bytes(_scaled_svg(vector.getvalue(), scale))
        # strong compression takes half of the time of a figure and saves a seventh of its file
        printed: Any = {"dpi": (PNG_DPI, PNG_DPI), "compress_level": 1}
        given: Any = {"metadata": metadata, "pil_kwargs": printed, "bbox_inches": box}
        figure.savefig(path, dpi=PNG_DPI * scale, **given)
    return [vector_path, path]


def _rc(settings: FigureSettings) -> Any:
    # names of parts by their content, so that equal figures are equal files
    chosen: dict[str, Any] = {"svg.fonttype": "none", "svg.hashsalt": "skewbridge"}
    font = settings.font
    if font == "sans-serif":  # a search for each of matplotlib's fourteen takes a tenth of a figure
        chosen["font.sans-serif"] = _SANS_SERIF
    else:
        chosen["font.family"] = [font, _EVERY_SIGN]
    if font == "serif":
        chosen["mathtext.fontset"] = "dejavuserif"
    elif font not in GENERIC_FONTS:
        faces = {"rm": font, "cal": font, "it": f"{font}:italic", "bf": f"{font}:bold"}
        chosen |= {"mathtext.fontset": "custom"}
        chosen |= {f"mathtext.{face}": name for face, name in faces.items()}
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
