"""Figures of a study: list with captions, drawing, and files of a given width and font."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import pandas as pd
from joblib import Parallel, delayed
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from skewbridge.demands.columns import demands_for, label_of
from skewbridge.demands.validity import COLUMN_FAILURE_RATIO, with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.tables import figure_metadata, read_frame
from skewbridge.files.text import shortened, write_text
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS
from skewbridge.fragility.settings import EFFECT_CONFIDENCE
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.report import answer, appearance, fragility_figures
from skewbridge.report.answer import model_name, short_names
from skewbridge.report.run_figures import applied_spectra
from skewbridge.study.config import DESIGN_FONT_PT, GENERIC_FONTS, FigureSettings
from skewbridge.study.folder import StudyFolder
from skewbridge.units import INCH, MM
from skewbridge.variant.axes import axis
from skewbridge.variant.variant import ABUTMENTS

#: Templates of the captions for each kind of figure.
CAPTIONS: Final = {kind: texts for kind, texts in appearance.TEXTS.items() if "section" in texts}
#: Sections of the figures: the leading curves, then the gallery of the page in its order.
SECTIONS: Final = tuple(dict.fromkeys(caption["section"] for caption in CAPTIONS.values()))
_TABLES: Final = ("demands", "curves", "effects", "medians", "system", "intensity_effects")
_TEXTS: Final = appearance.templates(*map(vars, (appearance, answer, fragility_figures)))
PNG_DPI: Final = 300
#: Least number of figures per process: a start takes as long as drawing five figures.
FIGURES_OF_A_PROCESS: Final = 12
#: Font that contains all characters of the figures.
_EVERY_SIGN: Final = "DejaVu Sans"
_SANS_SERIF: Final = [_EVERY_SIGN, "Verdana"]  # Verdana is as wide, if a viewer lacks the first
#: Smallest and largest width of a figure before it is scaled / its designed width.
_NARROWEST, _WIDEST = 0.8, 2.0
_WIDER: Final = 1.1  # factor of the width of a figure whose panels overlap
_MARGIN_IN: Final = 0.1  # white margin of a figure
_SVG_SIZE: Final = re.compile(rb'(<svg [^>]*)width="([\d.]+)pt" height="([\d.]+)pt"')

type Drawing = Callable[[], Figure]


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """Text of the report about a figure; its parts are described in `captions.yaml`."""

    name: str
    section: str
    title: str
    text: str
    finding: str
    item: str
    model: str = ""  # bridge and abutment model; empty for a figure of the whole study


type StudyFigure = tuple[Caption, Drawing]


def study_figures(
    tables: Mapping[str, pd.DataFrame], suite: Sequence[SuiteMotion] = ()
) -> Iterator[StudyFigure]:
    """Yield caption and drawing function of each figure; the main curves come first.

    ``tables`` has the tables in `_TABLES`, and ``choices`` after `make choices`.
    """
    demands = with_derived_columns(tables["demands"])
    tables = {**tables, "demands": demands}
    all_curves = fragility_figures.with_system(tables["curves"], tables["system"])
    pooled = fragility_figures.pooled_curves(all_curves, tables["medians"])
    leading = fragility_figures.main_curves(pooled)
    for name, table in leading.items():
        yield _curve_figure("main", name, table, all_curves, demands)
    other_curves = pooled.drop(index=[row for table in leading.values() for row in table.index])
    models = demands[list(BRIDGE_COLUMNS)].drop_duplicates().itertuples(index=False)
    for bridge, abutment in sorted(models):
        code = ABUTMENTS[abutment].code if abutment in ABUTMENTS else abutment
        prefix, model = f"{bridge}_{code}_", model_name(bridge, abutment)

        def of_model(table: pd.DataFrame, model: Any = (bridge, abutment)) -> pd.DataFrame:
            return table[(table["bridge"] == model[0]) & (table["abutment"] == model[1])]

        of_this = {name: of_model(table) for name, table in tables.items()}
        others, model_curves = of_model(pooled), of_model(all_curves)
        others = others[others["component"].isin(of_model(other_curves)["component"])]
        curves = (
            _curve_figure("curves", str(name), table, model_curves, of_this["demands"])
            for name, table in others.groupby("component", sort=False)
        )
        drawings = (_cloud_figures, _intensity_figures, _choice_figures)
        for caption, draw in chain(curves, *(figures(of_this) for figures in drawings)):
            title = f"{model}: {caption.title}"
            name = re.sub(r"[^\w.-]+", "-", prefix + caption.name)  # part of file names
            yield replace(caption, name=name, title=title, model=model), draw
    if suite:
        caption = _caption("motions", scales=[item.scale for item in suite])
        yield caption, partial(applied_spectra, suite)


def _caption(kind: str, **values: Any) -> Caption:
    texts = CAPTIONS[kind].items()
    return Caption(**{name: appearance.one_line(_TEXTS, text, **values) for name, text in texts})


def _curve_figure(
    kind: str, name: str, table: pd.DataFrame, curves: pd.DataFrame, demands: pd.DataFrame
) -> StudyFigure:
    (_, first_rows), *_ = appearance.groups_of(table, fragility_figures.STATE)
    caption = _caption(
        kind,
        component=name,
        im=str(curves["im"].iloc[0]),
        model=short_names(curves)[first_rows["bridge"].iloc[0], first_rows["abutment"].iloc[0]],
        first=first_rows.iloc[0],
        last=first_rows.iloc[-1],
        changed=axis(first_rows["axis"].iloc[0]),
        effect_level=EFFECT_CONFIDENCE,
        table=table,
    )
    columns = 2 if kind == "main" else 3
    return caption, partial(fragility_figures.curves_figure, table, curves, demands, columns)


def _cloud_figures(tables: Mapping[str, pd.DataFrame]) -> Iterator[StudyFigure]:
    demands, curves = tables["demands"], tables["curves"]
    for name in map(str, curves["demand"].unique()):
        if name == COLUMN_FAILURE_RATIO:  # its two modes have a figure each
            continue
        lowest = fragility_figures.least_shown(demands, curves, name) if name in demands else None
        if lowest is None:
            continue
        values, complete = demands[name].dropna(), demands["complete"]
        mildest = curves[curves["demand"] == name].sort_values("threshold").iloc[0]
        caption = _caption(
            "cloud",
            demand=name,
            least=lowest,
            mildest=mildest,
            total=len(demands),
            known=len(values),
            early=(~complete[values.index]).sum(),
            below=(complete & (demands[name] < lowest)).sum(),
            above=(values > mildest["threshold"]).sum(),
        )
        draw = partial(fragility_figures.demand_clouds, demands, curves, tables["effects"], name)
        yield caption, draw


def _intensity_figures(tables: Mapping[str, pd.DataFrame]) -> Iterator[StudyFigure]:
    table, effects = tables["intensity_effects"], tables["effects"]
    demands = demands_for("headline", table["demand"])
    if not demands:
        return
    im = str(tables["curves"]["im"].iloc[0])
    reference = table[table["at_reference"]]
    pooled = effects[effects["scope"] == "pooled"]
    caption = _caption(
        "intensity",
        tests=pooled.loc[pooled["demand"].isin(demands), "p_slope"].dropna(),
        level=table["level"].iloc[0],
        reference=reference,
        inside=reference.loc[~reference["clipped"], "im"].head(1),
        max_bands=appearance.MAX_BANDS,
        im=im,
    )
    yield caption, partial(fragility_figures.effects_by_intensity, table, label_of(im))


def _choice_figures(tables: Mapping[str, pd.DataFrame]) -> Iterator[StudyFigure]:
    choices = tables.get("choices", pd.DataFrame())
    if choices.empty:
        return
    caption = _caption(
        "choices",
        findings=fragility_figures.choice_findings(choices),
        pairs=choices["n_pairs"].max(),
        failed=choices.drop_duplicates(["kind", "name", "to_value"])["n_failed"].sum(),
        linear_pct=fragility_figures.LINEAR_PCT,
    )
    yield caption, partial(fragility_figures.tornado, choices)


def _figures_of(paths: Mapping[str, Path]) -> list[StudyFigure]:
    """Return the figures of a study from the files of its tables, suite and choices optional."""
    names = [*_TABLES, *({"choices"} & paths.keys())]
    suite = read_suite(paths["suite"]) if "suite" in paths else ()
    return list(study_figures({name: read_frame(paths[name]) for name in names}, suite))


def read_captions(path: Path) -> list[Caption]:
    """Return the captions of the figures of a study, in the order of the file."""
    return [Caption(**item) for item in json.loads(path.read_text("utf-8"))["figures"]]


def draw_study(
    paths: Mapping[str, Path],
    *,
    folder: Path,
    captions: Path,
    settings: FigureSettings,
    provenance: Mapping[str, str] | None = None,
    n_jobs: int = 1,
) -> None:
    """Draw all figures of a study as SVG and PNG, and write their captions.

    ``paths`` maps the names in `_TABLES` to files, and also suite and choices if these exist;
    ``provenance`` is stored in the metadata of the files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with appearance.shown_in(settings.units):
        figures = _figures_of(paths)
    n_jobs = min(n_jobs, max(1, len(figures) // FIGURES_OF_A_PROCESS))
    Parallel(n_jobs=n_jobs, backend="loky")(
        delayed(save_figure)(draw, settings, folder, caption.name, provenance)
        for caption, draw in figures
    )
    write_text(captions, json.dumps({"figures": [asdict(item) for item, _ in figures]}, indent=1))


def finished_figures(results: Path) -> list[StudyFigure]:
    """Return caption and drawing of each figure of a study; `InputError` if a table is missing."""
    folder = StudyFolder(results)
    paths = folder.report_inputs | {"choices": folder.modelling_choices}
    for path in (paths[name] for name in _TABLES):
        if not path.is_file():
            raise InputError(f"{path} is missing: finish the study first", file=str(path))
    return _figures_of({name: path for name, path in paths.items() if path.is_file()})


def draw_figures(
    figures: Sequence[StudyFigure], names: Sequence[str], settings: FigureSettings, folder: Path
) -> list[Path]:
    """Draw the named figures of a study as SVG and PNG; return the files.

    `InputError`, and no figure, if a name matches none (``*`` matches any text).
    """
    drawings = {caption.name: draw for caption, draw in figures}
    selected: dict[str, Drawing] = {}
    for name in names:
        if not (matching := [drawing for drawing in drawings if fnmatchcase(drawing, name)]):
            similar = get_close_matches(name, drawings, n=3) or list(drawings)[:3]
            text = f"unknown figure {shortened(name)}; similar names: {', '.join(similar)}"
            raise InputError(f"{text}; `skewbridge study plot` lists all figures")
        selected |= {drawing: drawings[drawing] for drawing in matching}
    files = (save_figure(draw, settings, folder, name) for name, draw in selected.items())
    return [path for pair in files for path in pair]


def save_figure(
    draw: Drawing,
    settings: FigureSettings,
    folder: Path,
    name: str,
    provenance: Mapping[str, str] | None = None,
) -> list[Path]:
    """Draw a figure, write it as SVG (texts stay text) and PNG, and return both paths.

    A different font size, or a width too small for its panels or the texts above them, scales the
    complete figure, so that its parts keep their positions. Both files store ``provenance`` in
    their metadata.
    """
    vector_path, path = (folder / f"{name}.{ending}" for ending in ("svg", "png"))
    metadata = figure_metadata(provenance) if provenance else {}
    with mpl.rc_context(_rc(settings)), appearance.shown_in(settings.units):
        scale = settings.font_size_pt / DESIGN_FONT_PT
        figure = _laid_out(draw, settings.width_mm and settings.width_mm * MM / INCH / scale)
        bbox = figure.get_tightbbox()
        if settings.width_mm is None:
            bbox = bbox.padded(_MARGIN_IN)
        else:  # titles may be wider than the panels
            bbox = Bbox.union([bbox, figure.bbox_inches])
            scale = settings.width_mm * MM / INCH / bbox.width
        vector = BytesIO()
        figure.savefig(vector, format="svg", metadata=metadata | {"Date": None}, bbox_inches=bbox)
        source = vector.getvalue()
        if scale != 1.0:  # change the size on paper, keep the view box
            source = _SVG_SIZE.sub(partial(_enlarged, scale), source, count=1)
        vector_path.write_bytes(source)
        # strong compression takes half of the time of a figure and makes its file a seventh smaller
        printed: Any = {"dpi": (PNG_DPI, PNG_DPI), "compress_level": 1}
        options: Any = {"metadata": metadata, "pil_kwargs": printed, "bbox_inches": bbox}
        figure.savefig(path, dpi=PNG_DPI * scale, **options)
    return [vector_path, path]


def _laid_out(draw: Drawing, width_in: float | None) -> Figure:
    """Return a figure with its layout, wider if its panels, with their texts, would overlap."""
    figure = draw()
    drawn_in = figure.get_figwidth()
    laid_out_in = drawn_in if width_in is None else max(width_in, _NARROWEST * drawn_in)
    while True:
        figure.set_figwidth(laid_out_in)
        for spine in (border for axes in figure.axes for border in axes.spines.values()):
            spine.set_in_layout(False)  # labels extend further; measuring spines takes a third
        if layout := figure.get_layout_engine():  # once, for both files
            layout.execute(figure)
            figure.set_layout_engine(None)  # with any engine, even "none", saving draws twice
        boxes = [box for axes in figure.axes if (box := axes.get_tightbbox())]
        overlap = any(box.count_overlaps(boxes) > 1 for box in boxes)  # each overlaps itself
        if not overlap or laid_out_in > _WIDEST * drawn_in:
            return figure
        laid_out_in *= _WIDER
        figure = draw()  # a second layout would start from the first


def _rc(settings: FigureSettings) -> Any:
    # a fixed salt: ids in the file depend on the content only, so equal figures are equal files
    rc_params: dict[str, Any] = {"svg.fonttype": "none", "svg.hashsalt": "skewbridge"}
    # hinted texts are up to 9 % narrower where they are measured than where they are drawn
    rc_params["text.hinting"] = "none"
    font = settings.font
    if font == "sans-serif":  # searching for all fourteen takes a tenth of the time
        rc_params["font.sans-serif"] = _SANS_SERIF
    else:
        rc_params["font.family"] = [font, _EVERY_SIGN]
    if font == "serif":
        rc_params["mathtext.fontset"] = "dejavuserif"
    elif font not in GENERIC_FONTS:
        faces = {"rm": font, "cal": font, "it": f"{font}:italic", "bf": f"{font}:bold"}
        rc_params |= {"mathtext.fontset": "custom"}
        rc_params |= {f"mathtext.{face}": name for face, name in faces.items()}
    return rc_params


def _enlarged(scale: float, match: re.Match[bytes]) -> bytes:
    width, height = (scale * float(size) for size in match.groups()[1:])
    return match[1] + f'width="{width:.6g}pt" height="{height:.6g}pt"'.encode()
