"""Figures in files for a paper: SVG and PNG of a given width and font."""

import re
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure

from skewbridge.study.figure_settings import DESIGN_FONT_PT, GENERIC_FONTS, FigureSettings
from skewbridge.units import INCH, MM

PNG_DPI: Final = 300
#: Has every sign that the figures use.
_EVERY_SIGN: Final = "DejaVu Sans"
#: Part of its own width that a figure can be laid out in before its texts meet.
_NARROWEST: Final = 0.8
_SVG_SIZE: Final = re.compile(rb'(<svg [^>]*)width="([\d.]+)pt" height="([\d.]+)pt"')

type Drawing = Callable[[], Figure]


def save_figure(draw: Drawing, settings: FigureSettings, folder: Path, name: str) -> list[Path]:
    """Draw a figure and write it as SVG, with texts as texts, and as PNG.

    Another size of the font, or a width that its columns do not fit into, enlarges or reduces the
    figure as a whole, so that its parts keep their places.

    Args:
        draw: Draws it.
        settings: Width and font.
        folder: Where the files go.
        name: File name without ending.

    Returns:
        The two files.
    """
    vector_path, path = (folder / f"{name}.{ending}" for ending in ("svg", "png"))
    with mpl.rc_context(_rc(settings)):
        figure = draw()
        scale = _fit(figure, settings)
        tight: Any = {"bbox_inches": "tight"} if settings.width_mm is None else {}
        vector = BytesIO()
        figure.savefig(vector, format="svg", metadata={"Date": None}, **tight)
        vector_path.write_bytes(_scaled_svg(vector.getvalue(), scale))
        printed = {"dpi": (PNG_DPI, PNG_DPI)}
        figure.savefig(path, dpi=PNG_DPI * scale, pil_kwargs=printed, **tight)
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
    """Lay a figure out for its width; return the factor that its file is to be enlarged by."""
    scale = settings.font_size_pt / DESIGN_FONT_PT
    if settings.width_mm is None:
        return scale
    width_in = settings.width_mm * MM / INCH
    own_in, height_in = figure.get_size_inches()
    laid_out_in = max(width_in / scale, _NARROWEST * own_in)
    figure.set_size_inches(laid_out_in, height_in)
    return width_in / laid_out_in


def _scaled_svg(source: bytes, scale: float) -> bytes:
    """Return a drawing with another size on paper; its view box stays."""
    if scale == 1.0:
        return source

    def enlarged(found: re.Match[bytes]) -> bytes:
        width, height = (scale * float(size) for size in found.groups()[1:])
        return found[1] + f'width="{width:.6g}pt" height="{height:.6g}pt"'.encode()

    return _SVG_SIZE.sub(enlarged, source, count=1)
