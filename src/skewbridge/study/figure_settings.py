"""How the figures of a study look in a paper: section ``figures`` of the configuration."""

from difflib import get_close_matches
from typing import Annotated, Final

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.errors import InputError
from skewbridge.reading import Number, shortened

#: Families that every machine has; what they stand for is the choice of matplotlib.
GENERIC_FONTS: Final = ("sans-serif", "serif", "monospace")
#: Size of the labels that the figures are designed with.
DESIGN_FONT_PT: Final = 9.0


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class FigureSettings:
    """Width and font of the figures of the report."""

    width_mm: Number | None = Field(
        default=None,
        ge=40.0,
        le=500.0,
        description="width of every figure in its file, such as 85 or 175 for one or two columns "
        "of a journal; null for as wide as the panels of each need",
    )
    font: Annotated[str, Field(min_length=1, max_length=100)] = Field(
        default="sans-serif",
        description="family of all texts: sans-serif, serif, monospace or an installed one",
    )
    font_size_pt: Number = Field(
        default=DESIGN_FONT_PT,
        ge=4.0,
        le=24.0,
        description="size of the labels of the axes; titles and notes are in proportion. A figure "
        "with more columns than the width holds is made smaller as a whole",
    )


def check_font(name: str) -> None:
    """Check that there is a font.

    Args:
        name: A generic family or the name of a font.

    Raises:
        InputError: It is not installed; the message names those with a like name.
    """
    if name in GENERIC_FONTS:
        return
    from matplotlib.font_manager import get_font_names  # takes a second, and few studies need it

    installed = get_font_names()
    if name not in installed:
        like = get_close_matches(name, installed, n=3, cutoff=0.5)
        near = f" (installed: {', '.join(like)})" if like else ""
        told = f"{', '.join(GENERIC_FONTS)} or the name of an installed font{near}"
        raise InputError(f"figures.font must be {told}, got {shortened(name)}")
