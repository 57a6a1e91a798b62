"""Fixtures of the fault tests."""

import time
from collections.abc import Callable

import psutil
import pytest

_PATIENCE_S = 30.0


@pytest.fixture
def ended() -> Callable[[int], bool]:
    """Whether a process ends, waited for."""

    def wait_for(pid: int) -> bool:
        deadline = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline:
            if not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
            time.sleep(0.05)
        return False

    return wait_for
