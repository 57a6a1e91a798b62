"""Pytest plugin that records the lines of the package reached by each test, and its duration.

`mutants.py` uses it with ``-p reached_lines``; the variable REACHED_LINES names the output file.
"""

import json
import os
import sys
from collections import defaultdict
from collections.abc import Generator
from pathlib import Path
from types import CodeType
from typing import Any, Final

import pytest

_TOOL: Final = sys.monitoring.COVERAGE_ID
_PACKAGE: Final = f"{Path.cwd() / 'src' / 'skewbridge'}{os.sep}"


class ReachedLines:
    """Collector of lines by test; lines reached by a shared fixture belong to its test file."""

    def __init__(self) -> None:
        self._lines: set[tuple[str, int]] = set()
        self._shared: defaultdict[str, set[tuple[str, int]]] = defaultdict(set)
        self._tests: dict[str, dict[str, Any]] = {}
        sys.monitoring.use_tool_id(_TOOL, "reached lines")
        sys.monitoring.register_callback(_TOOL, sys.monitoring.events.LINE, self._reach)
        sys.monitoring.set_events(_TOOL, sys.monitoring.events.LINE)

    def _reach(self, code: CodeType, line: int) -> object:
        if code.co_filename.startswith(_PACKAGE):
            self._lines.add((code.co_filename.removeprefix(_PACKAGE), line))
        return sys.monitoring.DISABLE

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        self._lines = set()
        sys.monitoring.restart_events()
        result = yield
        self._tests.setdefault(item.nodeid, {"s": 0.0})["lines"] = sorted(self._lines)
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[Any], request: pytest.FixtureRequest
    ) -> Generator[None, Any, Any]:
        if fixturedef.scope == "function":
            return (yield)
        before, self._lines = self._lines, set()
        sys.monitoring.restart_events()
        result = yield
        self._shared[request.node.nodeid.split("::")[0]] |= self._lines
        self._lines |= before
        sys.monitoring.restart_events()
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        test = self._tests.setdefault(report.nodeid, {"s": 0.0})
        test["s"] += report.duration
        if not report.passed:
            test["not_passed"] = report.outcome

    def pytest_sessionfinish(self) -> None:
        sys.monitoring.free_tool_id(_TOOL)
        shared = {name: sorted(lines) for name, lines in self._shared.items()}
        found = {"tests": self._tests, "shared": shared}
        Path(os.environ["REACHED_LINES"]).write_text(json.dumps(found))


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(ReachedLines())
