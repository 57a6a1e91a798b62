"""Digests: an edit of a source reruns what it can change, and no analysis that it cannot."""

import shutil
from pathlib import Path

import pytest

import skewbridge
from skewbridge.files.digests import ENGINE, digest_of, layer_digest
from skewbridge.study.products import RECIPES

PACKAGE = Path(skewbridge.__file__).parent
ANALYSES = "the analyses themselves"
PARTS = {ANALYSES: ENGINE, **{rule: recipe.sources for rule, recipe in RECIPES.items()}}
#: Rules that list or run analyses; all but the last look at the journals, which say what is new.
ANALYSING = {"analyse", "sensitivity", "friction_pair", "modelling_choices", "check_predict"}
FITS = {"fit_fragility", "check_predict"}
PAGES = {"figures", "report"}
VERIFYING = {"verify_contact", "verification"}
ALL = {ANALYSES, *RECIPES}

#: A module or data file of every package: what its edit changes, and what it leaves alone. The
#: rules that follow in the workflow run again too; here it is the digest of each alone.
EDITS: dict[str, tuple[set[str], set[str]]] = {
    "units.py": (ALL, set()),
    "errors.py": (ALL, set()),
    "files/tables.py": ({*ANALYSING, *FITS, *PAGES}, {ANALYSES}),
    "variant/variant.py": ({ANALYSES, *ANALYSING}, set()),
    "variant/options.py": ({ANALYSES, *ANALYSING, *FITS}, set()),
    "fragility/settings.py": ({*FITS, *PAGES}, {ANALYSES, "analyse", "prepare_motions"}),
    "study/config.py": ({"report"}, ALL - PAGES),
    "motions/record.py": ({ANALYSES, *ANALYSING, "prepare_motions"}, {"fit_fragility"}),
    "motions/formats.py": ({"prepare_motions"}, {ANALYSES, "analyse", *FITS}),
    "motions/synthesis/ddk18.py": ({"prepare_motions", "verification"}, {ANALYSES, *FITS}),
    "contact/law.py": ({ANALYSES, *ANALYSING, *VERIFYING}, {"prepare_motions", "fit_fragility"}),
    "bridge/deck.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", "fit_fragility"}),
    "analysis/peaks.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", "fit_fragility"}),
    "demands/columns.py": ({"analyse", "collect_demands", *FITS, *PAGES}, {ANALYSES}),
    "fragility/effects.py": ({*FITS, *PAGES}, {ANALYSES, "analyse", "collect_demands"}),
    "study/journal.py": (ANALYSING, {ANALYSES, "fit_fragility"}),
    "study/session.py": (set(), ALL),
    "study/sensitivity.py": ({"sensitivity"}, ALL - {"sensitivity"}),
    "study/analyses.py": (ANALYSING, {ANALYSES}),
    "study/modelling_choices.py": ({"modelling_choices", *PAGES}, {"analyse", "check_predict"}),
    "report/checks.py": ({"fit_fragility", *PAGES}, {ANALYSES, *ANALYSING}),
    "report/html/page.py": (PAGES, ALL - PAGES),
    "report/html/templates/report.html.j2": (PAGES, ALL - PAGES),
    "verification/registry.py": (VERIFYING, ALL - VERIFYING),
    "files/text.py": (ALL, set()),
    "cli/output.py": (set(), ALL),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package."""
    folder = tmp_path_factory.mktemp("sources") / "skewbridge"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def before(tree: Path) -> dict[str, str]:
    return digests(tree)


def digests(package: Path) -> dict[str, str]:
    return {name: layer_digest(parts, package) for name, parts in PARTS.items()}


def test_every_package_is_edited_below() -> None:
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert {name.split("/")[0] for name in EDITS if "/" in name} == folders


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_changes_the_digests_of_dependent_rules(
    tree: Path, before: dict[str, str], name: str
) -> None:
    path = tree / name
    text = path.read_text()
    path.write_text(text + "\n\nADDED = 1.0\n")
    after = digests(tree)
    path.write_text(text)
    changed = {rule for rule in before if before[rule] != after[rule]}
    must, must_not = EDITS[name]
    assert must <= changed
    assert not must_not & changed


def test_bridges_are_digested_by_their_numbers_and_caches_not_at_all(
    tree: Path, before: dict[str, str]
) -> None:
    bridge = tree / "bridge/catalogue/osb1.yaml"
    bridge.write_text(bridge.read_text() + "# a note\n")
    cache = tree / "contact/__pycache__"
    cache.mkdir()
    (cache / "law.cpython-312.pyc").write_bytes(b"x")
    assert digests(tree) == before


def test_a_part_that_is_not_there_is_an_error(tree: Path) -> None:
    with pytest.raises(FileNotFoundError, match="cellar"):
        layer_digest(("contact", "cellar"), tree)


def test_numbers_that_differ_in_the_last_bit_have_other_keys() -> None:
    assert digest_of(0.1 + 0.2) != digest_of(0.3)
    assert digest_of(("a", 1)) == digest_of(("a", 1))
