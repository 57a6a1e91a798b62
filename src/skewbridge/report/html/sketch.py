"""Sketch of a bridge in plan, and the bridge in words, from its catalogue data."""

from collections import Counter
from collections.abc import Iterable, Sequence
from math import cos, radians, sin, tan
from typing import Any, Final

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.report.answer import counted
from skewbridge.report.axis_layout import shown_length

#: Size of the picture, and room around the bridge for walls and texts.
_WIDTH, _HEIGHT, _SIDE, _TOP = 520.0, 190.0, 8.0, 52.0
_GAP_SHARE: Final = 0.035  # of the length of the bridge, for the largest gap
_FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200)

type Point = tuple[float, float]


def bridge_words(bridge: BridgeData) -> str:
    """Return a bridge in words, such as ``two spans, pinned two-column bent``."""
    spans = f"{counted(len(bridge.spans_m), 'span')}, {shown_length(bridge.length_m)} long"
    bents = [
        f"{counted(columns).replace('one', 'single')}-column {'bent' if count == 1 else 'bents'}"
        for columns, count in Counter(bent.columns for bent in bridge.bents).items()
    ]
    supports = f"{bridge.base} {' and '.join(bents)}" if bents else "no bents"
    return f"{spans}, {supports}"


def sketch(
    bridge: BridgeData, skews_deg: Sequence[float], gaps_mm: Sequence[float], key_gap_mm: float
) -> dict[str, Any]:
    """Return the plan of a bridge as polygons and points of a picture.

    The deck is drawn at the largest skew of the study and as an outline at the others; walls and
    keys are outside it at the largest gap, exaggerated.

    Joint gaps are normal to the walls; ``key_gap_mm`` is that between deck and shear keys.

    Returns:
        ``deck``, ``outlines``, ``walls``, ``shear_keys`` (points of SVG polygons), ``columns``
        (x, y, radius), ``gap``, ``friction`` and ``arc`` of the skew (SVG paths), ``factor`` of
        the gaps, ``width`` and ``height``.
    """
    skew = max(skews_deg, key=abs)
    length, width = bridge.length_m, bridge.deck.width_m
    gap_m, key_m = max(gaps_mm) / 1000.0, key_gap_mm / 1000.0
    factor = next((f for f in reversed(_FACTORS) if f * gap_m <= _GAP_SHARE * length), _FACTORS[0])
    thickness = max(bridge.abutment.wall_thickness_m, 0.012 * length)
    reach = length / 2 + width / 2 * abs(tan(radians(skew)))
    reach += (factor * gap_m + thickness) / cos(radians(skew))
    scale = min((_WIDTH - 2 * _SIDE) / (2 * reach), (_HEIGHT - 2 * _TOP) / width)

    def at(x: float, y: float) -> Point:
        return round(_WIDTH / 2 + scale * x, 1), round(_HEIGHT / 2 - scale * y, 1)

    def points(corners: Iterable[Point]) -> str:
        return " ".join(f"{x},{y}" for x, y in (at(*corner) for corner in corners))

    def end(sign: float, away: float, y: float, angle: float = skew) -> Point:
        """Return the point of a line parallel to an end of the deck, so far outside of it."""
        return sign * (length / 2 + away / cos(radians(angle))) - y * tan(radians(angle)), y

    def line(first: Point, last: Point) -> str:
        return "M{},{} L{},{}".format(*at(*first), *at(*last))

    def outline(angle: float) -> str:
        ends = ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
        return points(end(sign, 0.0, side * width / 2, angle) for sign, side in ends)

    start, stop = factor * gap_m, factor * gap_m + thickness
    half, key = width / 2, thickness
    beyond = half + factor * key_m
    columns: list[tuple[float, float, float]] = []
    for x_m, bent in zip(bridge.bent_positions_m, bridge.bents, strict=True):
        radius = round(scale * bridge.column.diameter_m / 2, 1)
        for number in range(bent.columns):
            y = (number - (bent.columns - 1) / 2) * bent.column_spacing_m
            columns.append((*at(x_m, y), radius))
    middle = end(-1.0, 0.0, 0.0)
    upright = middle[0], 0.8 * half
    x, y = at(middle[0] - 0.8 * half * sin(radians(skew)), 0.8 * half * cos(radians(skew)))
    radius = 0.8 * half * scale
    return {
        "width": _WIDTH,
        "height": _HEIGHT,
        "deck": outline(skew),
        "outlines": [outline(angle) for angle in sorted(set(skews_deg) - {skew})],
        "walls": [
            points(end(sign, away, side * half) for away, side in
                   ((start, -1), (start, 1), (stop, 1), (stop, -1)))
            for sign in (-1.0, 1.0)
        ],
        "shear_keys": [
            points((end(sign, -2.2 * key, side * beyond), end(sign, 0.0, side * beyond),
                    end(sign, 0.0, side * (beyond + key)),
                    end(sign, -2.2 * key, side * (beyond + key))))
            for sign in (-1.0, 1.0)
            for side in (-1.0, 1.0)
        ],
        "columns": columns,
        "gap": line(end(1.0, 0.0, -0.5 * half), end(1.0, start, -0.5 * half)),
        "friction": line(end(1.0, start, 0.2 * half), end(1.0, start, 0.8 * half)),
        "arc": f"{line(middle, upright)} A{radius:.1f} {radius:.1f} 0 0 {int(skew < 0)} {x},{y}",
        "factor": factor,
    }  # fmt: skip
