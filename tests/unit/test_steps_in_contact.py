"""Step sizes follow the state of the contacts."""

from dataclasses import dataclass, field
from math import inf

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import LONGEST_S, LOOK_AHEAD, SWING_S, StepLoop

SETTINGS = AnalysisSettings(dt_s=0.010, contact_dt_s=0.005, event_dt_s=0.0003125)
DT_S, CONTACT_DT_S, FINEST_S = 0.010, 0.005, 0.0003125
MUCH, LITTLE, FAIR = 2 * SETTINGS.max_friction_error, 0.0, 0.5 * SETTINGS.max_friction_error


@dataclass
class Contacts:
    """Contacts with prescribed friction errors and changes; records the step sizes."""

    errors: list[float] = field(default_factory=list)  # after each step
    closes_after: int = -1  # number of the step
    time_to_change: float = inf
    is_any_closed: bool = True
    least_opening_ratio = 1.0
    sizes_s: list[float] = field(default_factory=list)

    def start_from_rest(self) -> None:
        """Nothing moves yet."""

    def prepare(self, dt_s: float) -> None:
        """Nothing depends on the length."""

    def after_step(self, dt_s: float) -> None:
        self.sizes_s.append(dt_s)

    def time_to_change_s(self) -> float:
        return self.time_to_change

    def time_to_closing_s(self, accel_mps2: float) -> float:
        return inf

    @property
    def changes(self) -> tuple[int, ...]:
        return (0,) if len(self.sizes_s) == self.closes_after else ()

    @property
    def friction_error(self) -> float:
        number = len(self.sizes_s) - 1
        return self.errors[number] if 0 <= number < len(self.errors) else FAIR


def sizes_s(contacts: Contacts, steps: int, settings: AnalysisSettings = SETTINGS) -> list[float]:
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    assert StepLoop(contacts, settings).run(steps, lambda: None).status == "ok"
    assert sum(contacts.sizes_s) == pytest.approx(steps * settings.dt_s)
    return contacts.sizes_s


class Swinging(Contacts):
    """Contacts that are near closing after the second step only."""

    least_opening_ratio = property(lambda self: 0.7 if len(self.sizes_s) == 2 else 0.8)

    def time_to_closing_s(self, accel_mps2: float) -> float:
        return 0.0


def test_steps_are_shorter_while_the_deck_swings_and_for_some_time_after() -> None:
    found = sizes_s(Swinging(is_any_closed=False), 40)
    swing = [size for size in found[2:] if size < DT_S]
    assert found[: 2 + len(swing)] == [DT_S] * 2 + swing
    assert sum(swing) == pytest.approx(SWING_S)


#: Contacts and the sizes of the steps made in three regular steps, s.
CASES = {
    "halved at a large error": (
        Contacts(errors=[FAIR, MUCH, MUCH, FAIR, MUCH]),
        [5e-3] * 2 + [2.5e-3, *[1.25e-3] * 2, *[0.625e-3] * 24],
    ),
    "from the finest after a closing": (
        Contacts(closes_after=2, errors=[LITTLE] * 99),
        [5e-3] * 2 + [FINEST_S * parts for parts in (1, 1, 2, 4, 8, 16)] + [5e-3] * 2,
    ),
    "constant at a moderate error": (Contacts(closes_after=2), [5e-3] * 2 + [FINEST_S] * 64),
    "shorter before a change": (
        Contacts(is_any_closed=False, time_to_change=LOOK_AHEAD * 1.3e-3), [1.25e-3] * 24,
    ),
    "longer in the open": (Contacts(is_any_closed=False), [DT_S, 2 * DT_S]),
    "shorter in contact": (Contacts(), [CONTACT_DT_S] * 6),
}  # fmt: skip


@pytest.mark.parametrize(("contacts", "expected"), CASES.values(), ids=CASES)
def test_steps_follow_closings_and_the_friction_error(contacts, expected) -> None:
    assert sizes_s(contacts, 3) == expected


def test_steps_have_limits_and_are_regular_without_event_steps() -> None:
    # far from closing they are made together; the first ones prove the tangent
    assert max(sizes_s(Contacts(is_any_closed=False), 20)) == pytest.approx(LONGEST_S)
    found = sizes_s(Contacts(errors=[MUCH] * 99), 2)
    assert min(found) == found[-1] == FINEST_S
    plain = AnalysisSettings(dt_s=0.002, contact_dt_s=None, event_dt_s=None)
    contacts = Contacts(errors=[MUCH] * 99, closes_after=1, time_to_change=1e-9)
    assert sizes_s(contacts, 3, plain) == [0.002] * 3
