"""When an analysis stops: the limits of collapse, and those beyond which it has diverged."""

from collections.abc import Sequence
from math import hypot
from typing import Final

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.trace import Layout
from skewbridge.bridge.handles import BridgeModel, PlanVector
from skewbridge.errors import InputError

# ASSUME no bridge moves this fast. A diverging solution goes on converging, with forces of any
# size: these end it. They are far beyond what a bridge can do, and are no criteria of collapse.
MAX_STEP_DRIFT: Final = 0.05
MAX_STEP_DISP_M: Final = 0.5
MAX_CONTACT_WEIGHTS: Final = 5.0  # normal force of one contact over the weight of the bridge


class Watch:
    """Compares each step with the limits; `start` is the row under gravity.

    Raises:
        InputError: The joint gap leaves the deck no support on its seat.
    """

    def __init__(
        self, model: BridgeModel, layout: Layout, start: Sequence[float], settings: AnalysisSettings
    ) -> None:
        self._settings = settings
        self._max_normal_n = MAX_CONTACT_WEIGHTS * model.weight_n
        self._normals = layout.contacts("normals")
        self._deck = _Point(layout, start, model.deck_centre_node)
        self._columns = tuple(
            (
                _Point(layout, start, column.top_node),
                _Point(layout, start, column.base_node),
                column.clear_height_m,
            )
            for column in model.columns
        )
        self._corners = tuple(
            (_Point(layout, start, corner.node), abutment.normal, abutment.support_length_m)
            for abutment in model.abutments
            for corner in abutment.corners
        )
        self._last_drift = self._last_disp_m = 0.0
        for abutment in model.abutments:
            if abutment.support_length_m <= 0.0:
                raise InputError(
                    f"gap_mm must be below the seat width of {abutment.seat_width_m * 1e3:g} mm, "
                    f"got {abutment.gap_m * 1e3:g}"
                )

    def diverged(self, row: Sequence[float]) -> str:
        """Return why the state cannot be a solution, or an empty text.

        Call it before `collapsed`: a solution that has diverged is no proof of collapse.
        """
        drift, disp_m = self._drift(row), self._disp_m(row)
        step_drift, step_disp_m = drift - self._last_drift, disp_m - self._last_disp_m
        self._last_drift, self._last_disp_m = drift, disp_m
        # Negated comparisons, so that a value that is no number is caught.
        if not abs(step_drift) <= MAX_STEP_DRIFT:
            return f"drift changed by {step_drift:.3g} in one step"
        if not abs(step_disp_m) <= MAX_STEP_DISP_M:
            return f"the deck moved by {step_disp_m:.3g} m in one step"
        largest = max(row[self._normals], default=0.0)
        if not largest <= self._max_normal_n:
            return f"a contact carries {largest:.3g} N"
        return ""

    def collapsed(self, row: Sequence[float]) -> str:
        """Return the name of the demand whose limit is passed, or an empty text."""
        if self._drift(row) >= self._settings.collapse_drift_ratio:
            return "column_drift_ratio"
        for point, normal, support_m in self._corners:
            x, y = point.disp(row)
            if -(x * normal[0] + y * normal[1]) > support_m:
                return "unseating_m"
        if self._disp_m(row) > self._settings.collapse_deck_disp_m:
            return "deck_disp_m"
        return ""

    def _disp_m(self, row: Sequence[float]) -> float:
        return hypot(*self._deck.disp(row))

    def _drift(self, row: Sequence[float]) -> float:
        largest = 0.0
        for top, base, height_m in self._columns:
            (top_x, top_y), (base_x, base_y) = top.disp(row), base.disp(row)
            drift = hypot(top_x - base_x, top_y - base_y) / height_m
            if not drift <= largest:
                largest = drift
        return largest


class _Point:
    """A node's place in a row, with its displacement under gravity."""

    __slots__ = ("_arm_x", "_arm_y", "_at", "_x", "_y")

    def __init__(self, layout: Layout, start: Sequence[float], node: int) -> None:
        follower = layout.followers.get(node)
        read, (self._arm_x, self._arm_y) = (
            (follower.leader, follower.arm_m) if follower else (node, (0.0, 0.0))
        )
        self._at = layout.node(read) if read in layout.nodes else -1
        self._x = self._y = 0.0
        self._x, self._y = self.disp(start)

    def disp(self, row: Sequence[float]) -> PlanVector:
        """Return the plan displacement since gravity."""
        at = self._at
        if at < 0:
            return 0.0, 0.0
        turned = row[at + 5]
        x, y = row[at] - self._arm_y * turned, row[at + 1] + self._arm_x * turned
        return x - self._x, y - self._y
