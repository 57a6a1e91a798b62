"""Wrong, hostile, absurd, cut or altered input: refused in one sentence before anything runs."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from cli_json import invoke
from motions_files import make_pairs
from mutated_files import BOMB
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.cli.output import emit_table
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, read_table, stamp, write_csv, write_frame
from skewbridge.files.text import read_csv, read_json, read_yaml
from skewbridge.fragility.fit_data import read_data
from skewbridge.motions.folder import list_motions, write_index
from skewbridge.motions.read import read_trace
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import check_inputs


@pytest.mark.parametrize(
    ("read", "content", "words"),
    [
        (read_yaml, b"a: 1\nb: \xff\n", "line 2: byte 0xff is not UTF-8"),
        (read_yaml, b"a: 1\nb: 2\na: 3\n", "line 3: not valid YAML: the key 'a' appears twice"),
        (read_yaml, b"[" * 100_000, "nested too deeply"),
        (read_yaml, BOMB.encode(), "more than 20000 values"),
        (read_yaml, b"a: &a [*a]\n", "nested too deeply"),
        (read_yaml, b"a: " + b"9" * 5000, "at most 30 digits"),
        (read_yaml, b"a: 0x" + b"f" * 5000, "at most 30 digits"),
        (read_yaml, b"1: a\n", "a key must be text"),
        (read_yaml, b"? [a]\n: b\n", "a key must be text"),
        (read_yaml, b"a: !!python/name:os.system x\n", "constructor for the tag"),
        (read_yaml, b"a: !!binary eA==\n", "constructor for the tag"),
        (read_yaml, b"x" * 300_000, "at most 200000 are read"),
        (read_yaml, b"a: [1\n", "not valid YAML"),
        (read_json, b'{"a": ' * 100_000, "nested too deeply"),
        (read_json, b'{"a": 1, "a": 2}', "'a' appears twice"),
        (read_json, b'{"a": ' + b"9" * 5000 + b"}", "Exceeds the limit"),
        (read_json, b"{", "line 1 column 2"),
        (read_csv, b"a,b\n1,2\n3\n", "line 3 has 1 cells, the header 2"),
        (read_csv, b"a,b\n1,2,3\n", "line 2 has 3 cells"),
        (read_csv, b"a,a\n1,2\n", "'a' appears twice"),
        (read_csv, b"", "it is empty"),
        (read_csv, b'a,b\n"1,2\n', "not a table"),
    ],
)
def test_document_over_the_limits_is_refused(tmp_path, read, content, words):
    path = tmp_path / "document"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read(path)
    assert "document" in str(caught.value)
    assert words in str(caught.value)


def test_aliases_are_expanded_and_dates_are_text(tmp_path):
    path = tmp_path / "file.yaml"
    path.write_text("a: &a {x: 1}\nb: {<<: *a, y: 2}\nc: *a\nd: 2020-01-31\n", encoding="utf-8")
    expected = {"a": {"x": 1}, "b": {"x": 1, "y": 2}, "c": {"x": 1}, "d": "2020-01-31"}
    assert read_yaml(path) == expected


@pytest.mark.parametrize("name", ["x" * 100_000, "a/" * 3000, "nul\0", "no/such/file", ""])
def test_absurd_file_name_is_refused(name):
    for read in (read_yaml, read_table, read_trace, load_bridge, read_data, list_motions):
        with pytest.raises(InputError) as caught:
            read(Path(f"{name}.yaml"))
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize("marked", [False, True])
def test_damaged_table_is_never_read_as_another(tmp_path, *, marked):
    """Pages carry checksums: a flipped byte changes no number in silence."""
    path = tmp_path / "t.parquet"
    table = pd.DataFrame({"a": np.linspace(0.0, 1.0, 50), "b": [f"text {i}" for i in range(50)]})
    write_frame(table, path, {"made_by": "tests"})
    if marked:
        stamp(path, {"rule": "fit_fragility"})
    content = path.read_bytes()
    for place in range(0, len(content), 7):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :])
        try:
            found = read_frame(path)
        except InputError:
            continue
        shared = [name for name in ("a", "b") if name in found]
        pd.testing.assert_frame_equal(found[shared], table[shared], check_dtype=False)
    for length in range(0, len(content), 97):
        path.write_bytes(content[:length])
        with pytest.raises(InputError, match=r"t\.parquet"):
            read_frame(path)


def run(*arguments):
    """Exit code and message of a command; no error but the exit may reach the runner."""
    result = invoke(*arguments)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stderr


@pytest.mark.parametrize("name", ["../../etc/passwd", "..", "a/b", "x" * 100_000, "[/red]", "\0"])
def test_a_bridge_is_only_sought_in_its_folders(name, tmp_path):
    (tmp_path / "outside.yaml").write_text("extends: osb1\n", encoding="utf-8")
    inside = tmp_path / "inside"
    inside.mkdir()
    with pytest.raises(InputError, match="bridge must be one of"):
        load_bridge(name)
    child = inside / "mine.yaml"
    child.write_text("extends: ../outside\n", encoding="utf-8")
    with pytest.raises(InputError, match="no other bridge"):
        load_bridge(child)


@pytest.mark.parametrize("value", [1e300, 1e-300, 501.0])
def test_a_bridge_has_no_number_that_ends_the_solver(tmp_path, value):
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"extends: osb1\nspans_m: {{v: [{value!r}, 45.0], src: 'd: x'}}\n".replace("e+", ".0e+"),
        encoding="utf-8",
    )
    code, message = run("bridge", "modal", "--bridge", path)
    assert code == 2
    assert "mine.yaml: spans_m.0: must be" in message


def test_markup_and_control_characters_are_shown_as_text(capsys):
    emit_table([{"[/red]": "[/red] \x1b[31m"}], "[bold]")
    shown = capsys.readouterr().out
    assert "[/red]" in shown
    assert "[bold]" in shown
    assert "\x1b[31m" not in shown


def test_no_cell_of_an_export_is_a_formula(tmp_path):
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


def faults_of(tmp_path, states, raw):
    """Return the message about a configuration with these limit states."""
    path = tmp_path / "states.yaml"
    path.write_text(yaml.safe_dump(states), encoding="utf-8")
    raw["fragility"] = {"limit_states": str(path)} | raw.get("fragility", {})
    with pytest.raises(InputError) as caught:
        check_inputs(parse_config(raw))
    return str(caught.value)


STATE = {"component": "a", "demand": "column_drift_ratio", "unit": "percent", "dispersion": 0.3,
         "citation": "x", "states": {"slight": 1.0}}  # fmt: skip


def test_all_bad_inputs_of_a_study_are_reported_at_once(tmp_path):
    """A wrong unit, a missing citation and dispersion, measures, bridges and folders."""
    uncited, certain = ({k: v for k, v in STATE.items() if k != left_out}
                        for left_out in ("citation", "dispersion"))  # fmt: skip
    states = [STATE | {"unit": "kn"}, uncited | {"component": "b"}, certain | {"component": "c"}]
    motions = {"folder": str(tmp_path / "nowhere"), "design": "ida", "ida_demand": "foo_m"}
    raw = {"grid": {"bridge": ["osb9"]}, "motions": motions, "fragility": {"im": "im_pga"}}
    message = faults_of(tmp_path, states, raw)
    for words in (
        "'osb9'", "nowhere does not exist", "fragility.im must be one of", "motions.ida_demand",
        "entry 0: unit", "entry 1: citation: is missing", "entry 2: states.slight.dispersion",
    ):  # fmt: skip
        assert words in message
    assert message.startswith("7 faults:")


def test_a_demand_that_no_analysis_has_and_a_motion_that_cannot_be_read(tmp_path):
    motions = tmp_path / "motions"
    motions.mkdir()
    pairs = make_pairs(motions, 2)
    broken = pairs[0][0], pairs[1][1]
    for each in broken:
        each.write_text(each.read_text()[:-40] + " x.y\n")
    state = STATE | {"demand": "nothing_m", "unit": "m"}
    message = faults_of(tmp_path, [state], {"motions": {"folder": str(motions), "count": 2}})
    for words in ("no column 'nothing_m'", broken[0].name, broken[1].name, "3 faults"):
        assert words in message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("export", "x", "--format", "foo", "--out", "y"), "format must be one of nrml"),
        (("bridge", "modal", "--skew-deg", "x"), "--skew-deg"),
    ],
)
def test_bad_choice_is_reported_with_the_valid_ones(arguments, words):
    code, message = run(*arguments)
    assert code == 2
    assert words in message
    assert "Value error" not in message
