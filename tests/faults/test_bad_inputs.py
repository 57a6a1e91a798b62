"""Input that is wrong, hostile or absurd: exit 2 and one message, nothing run or written."""

import json
from pathlib import Path

import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from motions_files import make_pairs
from skewbridge.bridge.catalogue import load_bridge, load_bridge_file
from skewbridge.cli import build_app
from skewbridge.cli.output import emit_table
from skewbridge.errors import InputError
from skewbridge.fragility.exports import write_csv
from skewbridge.motions.folder import write_index
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import check_inputs


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and message of a command; no error but the exit may reach the runner."""
    result = CliRunner().invoke(build_app(), [str(each) for each in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stderr


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"im": [1, 2], "edp": [1, 2], "threshold": []}, "threshold is empty"),
        ({"im": 5, "edp": [1, 2], "threshold": 1}, "im must be a list"),
        ({"im": [1, 2], "edp": {"a": 1}, "threshold": 1}, "edp must be a list"),
        ({"im": [1, [2]], "edp": [1, 2], "threshold": 1}, "must be a number"),
    ],
)
def test_fit_refuses_columns_that_are_none(
    tmp_path: Path, data: dict[str, object], words: str
) -> None:
    path = tmp_path / "data.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    code, message = run("fit", path, "--method", "cloud")
    assert code == 2
    assert words in message


def test_fit_refuses_unequal_columns_of_runs(tmp_path: Path) -> None:
    path = tmp_path / "data.json"
    path.write_text(json.dumps({"im": [1, 2, 3], "edp": [1, 2]}), encoding="utf-8")
    options = ("--im", "im", "--edp", "edp", "--threshold", 1)
    code, message = run("fit", path, "--method", "cloud", *options)
    assert code == 2
    assert "columns differ in length" in message


@pytest.mark.parametrize("name", ["../../etc/passwd", "..", "a/b", "x" * 100_000, "[/red]", "\0"])
def test_a_bridge_is_only_sought_in_its_folders(name: str, tmp_path: Path) -> None:
    (tmp_path / "outside.yaml").write_text("extends: osb1\n", encoding="utf-8")
    inside = tmp_path / "inside"
    inside.mkdir()
    with pytest.raises(InputError, match="bridge must be one of"):
        load_bridge(name)
    child = inside / "mine.yaml"
    child.write_text("extends: ../outside\n", encoding="utf-8")
    with pytest.raises(InputError, match="no other bridge"):
        load_bridge_file(child)


@pytest.mark.parametrize("value", [1e300, 1e-300, 501.0])
def test_a_bridge_has_no_number_that_ends_the_solver(tmp_path: Path, value: float) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"extends: osb1\nspans_m: {{v: [{value!r}, 45.0], src: 'd: x'}}\n".replace("e+", ".0e+"),
        encoding="utf-8",
    )
    code, message = run("bridge", "modal", "--bridge", path)
    assert code == 2
    assert "mine.yaml: spans_m.0: must be" in message


def test_markup_and_control_characters_are_shown_as_text(
    capsys: pytest.CaptureFixture[str],
) -> None:
    emit_table([{"[/red]": "[/red] \x1b[31m"}], "[bold]")
    shown = capsys.readouterr().out
    assert "[/red]" in shown
    assert "[bold]" in shown
    assert "\x1b[31m" not in shown


def test_no_cell_of_an_export_is_a_formula(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    write_csv(pd.DataFrame({"name": ["=1+1", "@x", "plain"], "value": [-1.0, 2.0, 3.0]}), path)
    assert path.read_text(encoding="utf-8").splitlines()[1:] == [
        "'=1+1,-1.0",
        "'@x,2.0",
        "plain,3.0",
    ]
    index = tmp_path / "index.csv"
    write_index(index, [{"motion_id": "m", "event": "=cmd()", "magnitude": 7.0}])
    assert "'=cmd()" in index.read_text(encoding="utf-8")


def test_all_bad_inputs_of_a_study_are_reported_at_once(tmp_path: Path) -> None:
    """A wrong unit, a missing citation and dispersion, measures, bridges and folders."""
    states = [
        {"component": "a", "demand": "column_drift_ratio", "unit": "kn", "dispersion": 0.3,
         "citation": "x", "states": {"slight": 1.0}},
        {"component": "b", "demand": "column_drift_ratio", "unit": "percent", "dispersion": 0.3,
         "states": {"slight": 1.0}},
        {"component": "c", "demand": "column_drift_ratio", "unit": "percent", "citation": "x",
         "states": {"slight": 1.0}},
    ]  # fmt: skip
    path = tmp_path / "states.yaml"
    path.write_text(yaml.safe_dump(states), encoding="utf-8")
    raw = {
        "grid": {"bridge": ["osb9"]},
        "motions": {"folder": str(tmp_path / "nowhere"), "design": "ida", "ida_demand": "foo_m"},
        "fragility": {"im": "im_pga", "limit_states": str(path)},
    }
    with pytest.raises(InputError) as caught:
        check_inputs(parse_config(raw))
    message = str(caught.value)
    for words in (
        "'osb9'", "nowhere does not exist", "fragility.im must be one of", "motions.ida_demand",
        "entry 0: unit", "entry 1: citation: is missing", "entry 2: states.slight.dispersion",
    ):  # fmt: skip
        assert words in message
    assert message.startswith("7 faults:")


def test_a_demand_that_no_analysis_has_and_a_motion_that_cannot_be_read(tmp_path: Path) -> None:
    state = {"component": "a", "demand": "nothing_m", "unit": "m", "dispersion": 0.3,
             "citation": "x", "states": {"slight": 1.0}}  # fmt: skip
    path = tmp_path / "states.yaml"
    path.write_text(yaml.safe_dump([state]), encoding="utf-8")
    motions = tmp_path / "motions"
    motions.mkdir()
    make_pairs(motions, 2)
    broken = sorted(motions.glob("*.AT2"))
    for each in (broken[0], broken[3]):
        each.write_text(each.read_text()[:-40] + " x.y\n")
    raw = {
        "motions": {"folder": str(motions), "count": 2},
        "fragility": {"limit_states": str(path)},
    }
    with pytest.raises(InputError) as caught:
        check_inputs(parse_config(raw))
    for words in ("no column 'nothing_m'", broken[0].name, broken[3].name, "3 faults"):
        assert words in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("fit", "x.json", "--method", "foo"), "'foo' is not one of 'stripes', 'ida', 'cloud'"),
        (("export", "x", "--format", "foo", "--out", "y"), "format must be one of nrml"),
        (("bridge", "modal", "--skew-deg", "x"), "--skew-deg"),
    ],
)
def test_bad_choice_is_reported_with_the_valid_ones(arguments: tuple[str, ...], words: str) -> None:
    code, message = run(*arguments)
    assert code == 2
    assert words in message
    assert "Value error" not in message


def test_the_version_is_shown() -> None:
    result = CliRunner().invoke(build_app(), ["--version"])
    assert result.exit_code == 0
    assert result.stdout.startswith("skewbridge 0.")
