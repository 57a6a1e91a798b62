"""Digests: prose may change, meaning may not."""

from pathlib import Path

import pytest

from skewbridge.provenance import digests as provenance


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path)
    (tmp_path / "room.py").write_text('"""Doc."""\n\n\ndef f(x):\n    """Doc."""\n    return x\n')
    return tmp_path


def digest() -> str:
    provenance.source_digest.cache_clear()
    return provenance.source_digest("room")


def test_docstrings_and_comments_do_not_count(package: Path) -> None:
    before = digest()
    (package / "room.py").write_text("def f(x):  # now a comment\n    return x\n")
    assert digest() == before


def test_a_changed_expression_counts(package: Path) -> None:
    before = digest()
    (package / "room.py").write_text("def f(x):\n    return -x\n")
    assert digest() != before


def test_a_room_without_source_is_an_error(package: Path) -> None:
    with pytest.raises(FileNotFoundError):
        provenance.source_digest("cellar")


def test_numbers_that_differ_in_the_last_bit_have_other_keys() -> None:
    assert provenance.digest_of(0.1 + 0.2) != provenance.digest_of(0.3)
    assert provenance.digest_of(("a", 1)) == provenance.digest_of(("a", 1))
