"""The few variants of a grid on which the modeller's choices are tried."""

from collections.abc import Iterable, Sequence

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import Variant, parse_slug


def chosen_variants(variants: Iterable[Variant], named: Sequence[str]) -> list[str]:
    """Return the variants to change: those named, or two of each bridge of a grid.

    These are the most complete abutment model with the largest friction and the smallest gap, at
    the middle and the largest skew.

    Raises:
        InputError: A name is no variant, or of a bridge that the grid does not have.
    """
    by_bridge: dict[str, list[Variant]] = {}
    for variant in variants:
        by_bridge.setdefault(variant.bridge_name, []).append(variant)
    for slug in named:
        if (bridge := parse_slug(slug).bridge_name) not in by_bridge:
            raise InputError(f"modelling_choices.variants: {bridge} is not a bridge of the grid")
    return list(dict.fromkeys(named)) or [
        variant.slug for own in by_bridge.values() for variant in _typical(own)
    ]


def _typical(variants: Sequence[Variant]) -> list[Variant]:
    def rank(variant: Variant) -> tuple[float, ...]:
        models = list(ABUTMENTS)
        return models.index(variant.abutment), variant.friction_pct, -variant.gap_mm

    hardest = max(map(rank, variants))
    by_skew = {abs(each.skew_deg): each for each in variants if rank(each) == hardest}
    skews = sorted(by_skew)
    return [by_skew[skew] for skew in dict.fromkeys((skews[len(skews) // 2], skews[-1]))]
