"""Digests: an edit reruns what it can change, and nothing else."""

import re
import shutil
from pathlib import Path

import pytest

import skewbridge
from skewbridge.provenance.closure import closure
from skewbridge.provenance.digests import digest_of, source_digest
from skewbridge.provenance.syntax import SourceMemory
from skewbridge.study.keys import ANALYSIS_MODULE

ROOT = Path(skewbridge.__file__).parents[2]
SCRIPTS = sorted((ROOT / "workflow" / "scripts").glob("*.py"))
RULES = {path.stem for path in SCRIPTS}
#: Rules that draw figures or write pages, as the workflow says: for them labels count.
DRAWING = set(
    re.findall(
        r'script_digest\(\s*"(\w+)"(?:[^()]|\([^()]*\))*shown=True',
        "".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk")),
    )
)
ANALYSES = "the analyses themselves"
#: Rules that list or run analyses; all but the last look at the journals, which say what is new.
ANALYSING = {"plan", "analyse", "sensitivity", "friction_pair"}
FITS = {"fit_fragility"}
PAGES = {"figures", "report"}
MAKING = {"prepare_motions", "verification"}
ALL = {ANALYSES, *RULES}

#: A module or data file of every package: what its edit changes, and what it leaves alone. The
#: rules that follow in the workflow run again, too; here it is the digest of each alone.
EDITS: dict[str, tuple[set[str], set[str]]] = {
    "units.py": ({ANALYSES, *ANALYSING, "prepare_motions"}, set()),
    "errors.py": (ALL, set()),
    "provenance/tables.py": ({*ANALYSING, *FITS, *PAGES}, {ANALYSES}),
    "variant/variant.py": ({ANALYSES, *ANALYSING}, set()),
    # its numeric fields are axes, which the fits read, too
    "variant/options.py": ({ANALYSES, *ANALYSING, *FITS}, {"verify_contact"}),
    "motions/levels.py": ({"prepare_motions", *ANALYSING}, {ANALYSES, *FITS}),
    "fragility/settings.py": (FITS, {ANALYSES, *ANALYSING, "prepare_motions"}),
    # the methods in the page are written from the whole configuration
    "study/config.py": ({"report"}, ALL - {"report"}),
    "motions/record.py": ({ANALYSES, *ANALYSING, "prepare_motions"}, FITS),
    "motions/formats.py": ({"prepare_motions"}, {ANALYSES, *FITS}),
    # motions without files are made when a suite is prepared, and in the paper's studies
    "motions/synthesis/ddk18.py": (MAKING, ALL - MAKING),
    "motions/synthesis/data/ddk18.json": (MAKING, ALL - MAKING),
    "contact/law.py": ({ANALYSES, *ANALYSING, "verify_contact"}, {"prepare_motions", *FITS}),
    "bridge/deck.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", *FITS}),
    "analysis/peaks.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", *FITS}),
    "analysis/sdc.py": (set(), {ANALYSES, *ANALYSING}),
    "demands/columns.py": ({*ANALYSING, "collect_demands"}, {ANALYSES, "prepare_motions"}),
    "demands/tables.py": ({"collect_demands"}, {ANALYSES, "sensitivity", "prepare_motions"}),
    "fragility/effects.py": ({"fit_fragility"}, {ANALYSES, *ANALYSING, "collect_demands"}),
    "study/journal.py": (ANALYSING - {"friction_pair"}, {ANALYSES, *FITS}),
    "study/session.py": (RULES, {ANALYSES}),
    "study/sensitivity.py": ({"sensitivity"}, ALL - {"sensitivity"}),
    "report/checks.py": ({"check_results"}, {ANALYSES, *ANALYSING, *FITS}),
    "report/html/page.py": ({"report"}, ALL - {"report"}),
    "report/html/templates/report.html.j2": ({"report"}, ALL - {"report"}),
    "report/fragility_figures.py": ({"figures"}, ALL - PAGES),
    "verification/references/closed_forms.py": ({"verification"}, {ANALYSES, *ANALYSING, *FITS}),
    "verification/studies/gate.py": ({"verify_contact"}, {ANALYSES, *ANALYSING, *FITS}),
    "reading/tables.py": ({"prepare_motions"}, {ANALYSES}),
    "cli/output.py": (set(), ALL),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package and of the scripts."""
    folder = tmp_path_factory.mktemp("sources")
    shutil.copytree(ROOT / "src/skewbridge", folder / "skewbridge")
    shutil.copytree(ROOT / "workflow/scripts", folder / "scripts")
    return folder


def digests(tree: Path) -> dict[str, str]:
    """Digest of every rule's script, and of the module that runs one analysis."""
    source_digest.cache_clear()
    package = tree / "skewbridge"
    found = {
        rule: source_digest(tree / "scripts" / f"{rule}.py", package=package, shown=rule in DRAWING)
        for rule in RULES
    }
    return found | {ANALYSES: source_digest(ANALYSIS_MODULE, package=package)}


def test_every_package_is_edited_below() -> None:
    folders = {path.parent.name for path in (ROOT / "src/skewbridge").glob("*/__init__.py")}
    assert {name.split("/")[0] for name in EDITS if "/" in name} == folders
    assert PAGES <= DRAWING


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_changes_what_depends_on_it(tree: Path, name: str) -> None:
    path = tree / "skewbridge" / name
    text = path.read_text()
    added = "\n\ndef added():\n    return dict(value=1.0, label='old')\n"
    steps = [
        added,
        added.replace("def added():", "# why\ndef added():\n    '''What.'''"),
        added.replace("old", "new"),
        added.replace("1.0", "2.0"),
    ]
    found: list[dict[str, str]] = []
    for step in steps:
        path.write_text(text + step)
        found.append(digests(tree))
    path.write_text(text)
    before, comment, label, constant = found
    must, must_not = EDITS[name]
    changed = {rule for rule in before if before[rule] != constant[rule]}
    assert must <= changed
    assert not must_not & changed
    if path.suffix == ".py":
        assert comment == before
        assert {rule for rule in before if before[rule] != label[rule]} == changed & DRAWING


def test_nothing_but_the_analysis_is_in_the_key_of_an_analysis() -> None:
    """Scheduling, journals, configuration and readers may change without new analyses."""
    package = ROOT / "src/skewbridge"
    inside = {path.relative_to(package).as_posix() for path in closure(ANALYSIS_MODULE)}
    packages = {name.split("/")[0] for name in inside if "/" in name}
    assert packages == {
        "analysis",
        "bridge",
        "contact",
        "demands",
        "motions",
        "reading",
        "study",
        "variant",
    }
    assert {name for name in inside if name.startswith(("motions/", "study/"))} == {
        "motions/__init__.py",
        "motions/record.py",
        "study/__init__.py",
        "study/task.py",
    }
    assert not any(name.endswith(".yaml") for name in inside)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A small package with every way to depend on something."""
    files = {
        "__init__.py": "",
        "top.py": "from typing import TYPE_CHECKING\nfrom pack.part import one\n"
        "if TYPE_CHECKING:\n    from pack import types_only\n"
        "def f():\n    import pack.late\n",
        "late.py": "",
        "types_only.py": "",
        "part/__init__.py": "",
        "part/one.py": "STUDIES = {'a': 'pack.named:run'}\n",
        "part/numbers.csv": "1,2\n",
        "part/data/more.json": "{}",
        "part/.hidden": "",
        "named.py": "",
        "other.py": "",
    }
    for name, text in files.items():
        path = tmp_path / "pack" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "pack"


def test_the_closure_follows_every_kind_of_import(package: Path) -> None:
    names = {path.relative_to(package).as_posix() for path in closure("pack.top", package)}
    assert names == {
        "__init__.py",
        "top.py",
        "late.py",
        "named.py",
        "part/__init__.py",
        "part/one.py",
        "part/numbers.csv",
        "part/data/more.json",
    }


def test_a_module_without_source_is_an_error(package: Path) -> None:
    with pytest.raises(FileNotFoundError):
        closure("pack.cellar", package)


def test_numbers_that_differ_in_the_last_bit_have_other_keys() -> None:
    assert digest_of(0.1 + 0.2) != digest_of(0.3)
    assert digest_of(("a", 1)) == digest_of(("a", 1))


def test_what_a_source_says_is_remembered_by_its_bytes(tmp_path: Path) -> None:
    """Lines that are torn, and a file that cannot be written, only cost time."""
    path = tmp_path / "sources.jsonl"
    source = b"from skewbridge import units\nlabel = 1\n"
    first = SourceMemory(path).content(source, "skewbridge")
    assert first.names == ("skewbridge", "skewbridge.units")
    path.write_bytes(path.read_bytes() + b'{"key": "cut\n\xff\n')
    remembered = path.read_bytes()
    again = SourceMemory(path)
    assert again.content(source, "skewbridge") == first
    assert path.read_bytes() == remembered
    other = again.content(source + b"label = 2\n", "skewbridge")
    assert other.meaning != first.meaning
    nowhere = SourceMemory(tmp_path / "no" / "folder" / "sources.jsonl")
    assert nowhere.content(source, "skewbridge") == first
