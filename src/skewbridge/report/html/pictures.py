"""Figures of a study as they stand in the page: numbered, by section, packed into its text."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from joblib import Parallel, delayed
from matplotlib.image import imread, imsave
from numpy.typing import NDArray

from skewbridge.report.study_figures import Caption

# The files have 300 dots per inch for print, a screen shows half of them.
# Lossless WebP with few shades is smaller than lossy WebP of quality 40, and its texts are sharp.
# As SVG the figures of two bridges take 10 MB; files for papers lie in the folder of the figures.
_PACKING: Final = {"lossless": True, "quality": 60, "method": 4}
_SHADES: Final = 12  # of each primary colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure in the page.

    Attributes:
        number: Its number, from 1, in the order of the page.
        caption: What is said of it.
        data: Address that holds the whole picture.
        width: In pixels.
        height: In pixels.
    """

    number: int
    caption: Caption
    data: str
    width: int
    height: int


def pictures_of(
    captions: Sequence[Caption], folder: Path, order: Sequence[str]
) -> dict[str, list[Picture]]:
    """Return the figures by section, numbered in the order of the page.

    Args:
        captions: Captions of all figures.
        folder: Folder with a PNG file of each.
        order: Sections in the order of the page.
    """
    packed: Any = Parallel(n_jobs=2, backend="threading")(
        delayed(_packed)(folder / f"{caption.name}.png") for caption in captions
    )
    found: dict[str, list[Picture]] = {section: [] for section in order}
    shown = sorted(
        zip(captions, packed, strict=True), key=lambda pair: order.index(pair[0].section)
    )
    for number, (caption, (data, width, height)) in enumerate(shown, start=1):
        picture = Picture(number=number, caption=caption, data=data, width=width, height=height)
        found[caption.section].append(picture)
    return found


def _packed(path: Path) -> tuple[str, int, int]:
    pixels = np.round(_halved(imread(path)) * (_SHADES - 1)) / (_SHADES - 1)
    packed = BytesIO()
    imsave(packed, pixels, format="webp", pil_kwargs=_PACKING)
    data = base64.b64encode(packed.getvalue()).decode()
    return f"data:image/webp;base64,{data}", pixels.shape[1], pixels.shape[0]


def _halved(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a picture of half the width and height, each pixel the mean of four."""
    height, width = (2 * (size // 2) for size in pixels.shape[:2])
    blocks = pixels[:height, :width, :3].reshape(height // 2, 2, width // 2, 2, 3)
    return blocks.mean(axis=(1, 3))
