"""The process of the tests ends without OpenSees' message; hypothesis draws the same examples.

A change is not refused for an example that it did not bring. New examples are drawn by
`pytest --hypothesis-profile random tests/property`."""

import pytest
from hypothesis import settings
from reference_pages import ROOT

from skewbridge.study.processes import hush_exit_message

hush_exit_message()
settings.register_profile("random", deadline=None)
settings.register_profile("repeatable", deadline=None, derandomize=True, database=None)
settings.load_profile("repeatable")


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a bridge file and returns its path: made.yaml, made1.yaml."""

    def write(text, name=""):
        path = tmp_path / (name or f"made{len(list(tmp_path.glob('made*.yaml'))) or ''}.yaml")
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


@pytest.fixture
def in_the_repository(monkeypatch):
    monkeypatch.chdir(ROOT)
