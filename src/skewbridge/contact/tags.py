"""Free tags of a live OpenSees domain."""

from typing import Final, Protocol

import openseespy.opensees as ops

# ASSUME a user's own material tags lie below this one: OpenSees cannot be asked for them.
FIRST_FREE_MATERIAL: Final = 900_000
# Tags set aside for the materials of one element, so that two sources in one domain never collide.
_MATERIALS_PER_ELEMENT: Final = 8


class Tags(Protocol):
    """Anything that hands out unused tags, for example the allocator of a bridge model."""

    def node(self) -> int:
        """Return an unused node tag."""
        ...

    def element(self) -> int:
        """Return an unused element tag."""
        ...

    def material(self) -> int:
        """Return an unused uniaxial material tag."""
        ...

    def parameter(self) -> int:
        """Return an unused parameter tag."""
        ...


class TagSource:
    """Hands out tags above those that the domain has at the time of asking.

    Args:
        first_material: Materials get tags above this one.
    """

    def __init__(self, first_material: int = FIRST_FREE_MATERIAL) -> None:
        self._first = first_material
        self._next_material = first_material

    def node(self) -> int:
        """Return an unused node tag."""
        return max(_listed(ops.getNodeTags()), default=0) + 1

    def element(self) -> int:
        """Return an unused element tag."""
        return max(_listed(ops.getEleTags()), default=0) + 1

    def material(self) -> int:
        """Return an unused uniaxial material tag."""
        tag = max(self._next_material, self._first + _MATERIALS_PER_ELEMENT * self.element())
        self._next_material = tag + 1
        return tag

    def parameter(self) -> int:
        """Return an unused parameter tag."""
        return max(_listed(ops.getParamTags()), default=0) + 1


def _listed(tags: list[int] | int | None) -> list[int]:
    """Return what a tag query answered as a list: OpenSees gives a bare number for one tag."""
    if tags is None:
        return []
    return [tags] if isinstance(tags, int) else list(tags)
