"""Plan and description of a bridge from its catalogue data."""

from collections import Counter
from collections.abc import Sequence
from math import cos, radians, sin, tan
from typing import Any, Final

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.report.answer import counted
from skewbridge.report.axis_layout import shown_length

#: Size of the picture, and room around the bridge for walls and texts.
_WIDTH, _HEIGHT, _SIDE, _TOP = 520.0, 190.0, 8.0, 52.0
_GAP_SHARE: Final = 0.035  # of the length of the bridge, for the largest gap
_FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200)


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
    length, half = bridge.length_m, bridge.deck.width_m / 2
    gap_m = max(gaps_mm) / 1000.0
    factor = next((f for f in reversed(_FACTORS) if f * gap_m <= _GAP_SHARE * length), _FACTORS[0])
    thickness = max(bridge.abutment.wall_thickness_m, 0.012 * length)
    cosine, sine = cos(radians(skew)), sin(radians(skew))
    # along the bridge, on its axis: end of the deck, face and back of the wall
    end, face = length / 2, length / 2 + factor * gap_m / cosine
    back = face + thickness / cosine
    scale = min(
        (_WIDTH - 2 * _SIDE) / 2 / (back + half * abs(sine / cosine)),
        (_HEIGHT - 2 * _TOP) / 2 / half,
    )

    def at(x: float, y: float) -> tuple[float, float]:
        """Return the place of a point in the picture."""
        return round(_WIDTH / 2 + scale * x, 1), round(_HEIGHT / 2 - scale * y, 1)

    def skewed(x: float, y: float, angle: float = skew) -> str:
        """Return the place of a point on a line that is parallel to the ends of the deck."""
        return "{},{}".format(*at(x - y * tan(radians(angle)), y))

    def block(x_from: float, x_to: float, y_from: float, y_to: float, angle: float = skew) -> str:
        corners = ((x_from, y_from), (x_to, y_from), (x_to, y_to), (x_from, y_to))
        return " ".join(skewed(x, y, angle) for x, y in corners)

    beyond = half + factor * key_gap_mm / 1000.0
    inside = end - 2.2 * thickness / cosine
    columns = [
        (
            *at(x_m, (number - (bent.columns - 1) / 2) * bent.column_spacing_m),
            round(scale * bridge.column.diameter_m / 2, 1),
        )
        for x_m, bent in zip(bridge.bent_positions_m, bridge.bents, strict=True)
        for number in range(bent.columns)
    ]
    length_of_arms = 0.8 * half
    radius = scale * length_of_arms
    x, y = at(-end - length_of_arms * sine, length_of_arms * cosine)
    return {
        "width": _WIDTH,
        "height": _HEIGHT,
        "deck": block(-end, end, -half, half),
        "outlines": [block(-end, end, -half, half, each) for each in sorted({*skews_deg} - {skew})],
        "walls": [block(sign * face, sign * back, -half, half) for sign in (-1, 1)],
        "shear_keys": [
            block(sign * inside, sign * end, side * beyond, side * (beyond + thickness))
            for sign in (-1, 1)
            for side in (-1, 1)
        ],
        "columns": columns,
        "gap": f"M{skewed(end, -0.5 * half)} L{skewed(face, -0.5 * half)}",
        "friction": f"M{skewed(face, 0.2 * half)} L{skewed(face, 0.8 * half)}",
        "arc": f"M{skewed(-end, 0.0)} L{skewed(-end, length_of_arms, 0.0)} "
        f"A{radius:.1f} {radius:.1f} 0 0 {int(skew < 0)} {x},{y}",
        "factor": factor,
    }  # fmt: skip
