"""The pages of the documentation: links lead somewhere, commands and code are those that exist."""

import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd
import pytest
import typer
import yaml
from critical_skew import DATA, table_text
from matplotlib.figure import Figure
from typer.core import TyperGroup
from typer.main import get_command

from skewbridge.bridge.catalogue import bridge_schema
from skewbridge.cli import build_app
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.files.text import checked
from skewbridge.fragility.demand_table import ColumnMap
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.selection import Target
from skewbridge.study.config import StudyConfig, parse_config

mpl.use("Agg")
ROOT = Path(__file__).parents[2]
#: Written by docs/conf.py while the site is built.
GENERATED = {"columns.md", "commands.md", "effects_by_suite.md", "references.md"}
DOCS = (path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)
TOP = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "config/README.md", "motions/README.md")
PAGES = sorted([*(path for path in DOCS if path.name not in GENERATED), *(ROOT / n for n in TOP)])
NAMES = [str(path.relative_to(ROOT)) for path in PAGES]


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_to_a_file_and_a_heading(page: Path) -> None:
    prose = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    for target in re.findall(r"\]\((?!https?://)([^)\s]+)\)", prose):
        name, _, heading = target.partition("#")
        place = (page.parent / name).resolve() if name else page
        assert place.exists(), target
        if heading:
            titles = re.findall(r"^#+ (.*)$", place.read_text().lower(), re.M)
            anchors = {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in titles}
            assert heading in anchors, target


def fenced(language: str) -> Iterator[tuple[str, str]]:
    pattern = re.compile(rf"^( *)```{language}\n(.*?)^\1```", re.S | re.M)
    for page, name in zip(PAGES, NAMES, strict=True):
        for indent, text in pattern.findall(page.read_text()):
            yield name, re.sub(rf"^{indent}", "", text, flags=re.M)


BLOCKS = [text for _, text in fenced("sh")]
for page in PAGES:
    BLOCKS += re.findall(r"(?:^ {4,}\S.*\n)+", page.read_text().replace("\\\n", " "), re.M)
LINES = (line.strip() for block in BLOCKS for line in block.splitlines())
COMMANDS = sorted({line.split("   #")[0].split("  #")[0] for line in LINES})


@pytest.mark.parametrize("line", [each for each in COMMANDS if each.startswith("skewbridge ")])
def test_a_command_of_a_page_is_one_that_the_program_takes(line: str) -> None:
    group = get_command(build_app())
    assert isinstance(group, TyperGroup)
    context = typer.Context(group, info_name="skewbridge")
    line, *_ = line.replace(" [--study DIR]", "").split(" > ")
    command, rest = group, shlex.split(line)[1:]
    while isinstance(command, TyperGroup) and not rest[0].startswith("-"):
        _, command, rest = command.resolve_command(context, rest)
    if "--help" not in rest and "--version" not in rest:
        command.make_context("", rest)


@pytest.mark.parametrize("line", [each for each in COMMANDS if each.startswith("make ")])
def test_a_target_of_a_page_is_in_the_makefile(line: str) -> None:
    rules = (ROOT / "Makefile").read_text()
    for word in shlex.split(line)[1:]:
        variable, given, value = word.partition("=")
        if given:
            assert re.search(rf"^{variable} \?=|\$\((if )?\$?\(?{variable}", rules, re.M), word
            assert variable != "CONFIG" or (ROOT / value).is_file(), word
        else:
            assert re.search(rf"^{word}:", rules, re.M), word


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("finished")
    shutil.copytree(DEMO_STUDY, folder / "results")
    for name in ("smoke", "site"):
        (folder / "results" / name).symlink_to(DEMO_STUDY)
    return folder


@pytest.mark.parametrize(("name", "text"), list(fenced("python")))
def test_python_of_a_page_runs(name: str, text: str, finished: Path, monkeypatch) -> None:
    """What has no import continues a block before it or needs a model, and is parsed."""
    monkeypatch.chdir(finished)
    code = compile(text, name, "exec")
    if "import" in text:
        exec(code, {})
    plt.close("all")


@pytest.mark.parametrize(
    "path", sorted((ROOT / "docs/examples").glob("*.py")), ids=lambda path: path.stem
)
def test_example_of_the_gallery_draws(path: Path) -> None:
    names: dict[str, object] = {}
    exec(compile(path.read_text(), path, "exec"), names)
    figure = names.get("figure", plt.gcf())
    assert isinstance(figure, Figure)
    assert figure.axes
    plt.close("all")


@pytest.mark.parametrize(("name", "text"), list(fenced("yaml")))
def test_yaml_of_a_page_is_taken(name: str, text: str, tmp_path: Path) -> None:
    content = yaml.safe_load(text)
    if isinstance(content, list):
        (tmp_path / "states.yaml").write_text(text)
        assert load_limit_states(tmp_path / "states.yaml")
    elif "columns" in content:
        assert ColumnMap(**content).columns
    elif "extends" in content:
        assert set(content) <= {*bridge_schema()["properties"], "extends"}
    elif "measure" in content:
        assert checked(Target, content, name).levels
    elif "executor" in content:
        assert set(content) == {"executor", "jobs", "cores"}
    else:
        assert set(content) <= set(StudyConfig.model_fields)
        assert parse_config(content)


def test_stored_tables_name_their_command_and_that_of_the_critical_skew_is_printed() -> None:
    page = (ROOT / "docs/howto/critical_skew.md").read_text(encoding="utf-8")
    assert table_text(pd.read_csv(ROOT / DATA)) in page
    measured = yaml.safe_load((ROOT / "docs/data/measured.yaml").read_text())
    assert measured.keys() == {path.name for path in (ROOT / "docs/data").glob("*.csv")}
