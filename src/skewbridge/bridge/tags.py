"""The tag allocator of a model: no literal tags anywhere."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count


def _tags_from_one() -> Callable[[], int]:
    return count(1).__next__


@dataclass(frozen=True, slots=True)
class TagAllocator:
    """Hands out consecutive tags per kind; works as the tag source of a `ContactSet`."""

    node: Callable[[], int] = field(default_factory=_tags_from_one)
    element: Callable[[], int] = field(default_factory=_tags_from_one)
    material: Callable[[], int] = field(default_factory=_tags_from_one)
    section: Callable[[], int] = field(default_factory=_tags_from_one)
    transformation: Callable[[], int] = field(default_factory=_tags_from_one)
    integration: Callable[[], int] = field(default_factory=_tags_from_one)
    parameter: Callable[[], int] = field(default_factory=_tags_from_one)
    series: Callable[[], int] = field(default_factory=_tags_from_one)
    pattern: Callable[[], int] = field(default_factory=_tags_from_one)
    region: Callable[[], int] = field(default_factory=_tags_from_one)
