"""The tag allocator of a model: no literal tags anywhere."""

from collections import Counter


class TagAllocator:
    """Hands out consecutive tags per kind; works as the tag source of a `ContactSet`."""

    def __init__(self) -> None:
        self._last: Counter[str] = Counter()

    def _next(self, kind: str) -> int:
        self._last[kind] += 1
        return self._last[kind]

    def node(self) -> int:
        """Return an unused node tag."""
        return self._next("node")

    def element(self) -> int:
        """Return an unused element tag."""
        return self._next("element")

    def material(self) -> int:
        """Return an unused uniaxial material tag."""
        return self._next("material")

    def section(self) -> int:
        """Return an unused section tag."""
        return self._next("section")

    def transformation(self) -> int:
        """Return an unused tag of a geometric transformation."""
        return self._next("transformation")

    def integration(self) -> int:
        """Return an unused tag of a beam integration."""
        return self._next("integration")

    def parameter(self) -> int:
        """Return an unused parameter tag."""
        return self._next("parameter")

    def series(self) -> int:
        """Return an unused time series tag."""
        return self._next("series")

    def pattern(self) -> int:
        """Return an unused load pattern tag."""
        return self._next("pattern")

    def region(self) -> int:
        """Return an unused region tag."""
        return self._next("region")
