"""Wrong, hostile, absurd, cut or altered input: refused in one sentence before anything runs."""

import json
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

import mutated_files
from cli_json import answer, invoke
from motions_files import make_pairs
from mutated_files import BOMB, CONTACT
from reference_data import BAD
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

STATE = {"component": "a", "demand": "column_drift_ratio", "unit": "percent", "dispersion": 0.3,
         "citation": "x", "states": {"slight": 1.0}}  # fmt: skip
DECK = mutated_files.DECK | {"period_theta_s": 0.31623, "gap_normal_m": 0.00269}
PATH = [[0.0, 0.0, 0.0, -0.01], [0.1, 0.02, 0.01, -0.01], [0.2, 0.0, 0.02, 0.01]]
# for a file and 500 MB of memory more than the program itself
NAMES = tuple(mutated_files.FAMILIES)
RECORDS = NAMES[: NAMES.index("index")]
GROUPS = [NAMES[start::3] for start in range(3)]
SEED = 20261122


@pytest.mark.parametrize(
    ("read", "content", "words"),
    [
        (read_yaml, b"a: 1\nb: \xff\n", "line 2: byte 0xff is not UTF-8"),
        (read_yaml, b"a: 1\nb: 2\na: 3\n", "line 3: not valid YAML: the key 'a' appears twice"),
        (read_yaml, b"gap_mm: [25, 051]", "line 1: not valid YAML: '051' is not to base 10"),
        (read_yaml, b"dt_s: 1:30.5", "'1:30.5' is not to base 10: omit leading zeros, or quote"),
        (read_yaml, b"[" * 100_000, "nested too deeply"),
        (read_yaml, BOMB.encode(), "more than 20000 values"),
        (read_yaml, b"a: &a [*a]\n", "nested too deeply"),
        (read_yaml, b"a: " + b"9" * 5000, "at most 30 digits"),
        (read_yaml, b"1: a\n", "a key must be text"),
        (read_yaml, b"? [a]\n: b\n", "a key must be text"),
        (read_yaml, b"a: !!python/name:os.system x\n", "constructor for the tag"),
        (read_yaml, b"x" * 300_000, "at most 200000 are read"),
        (read_yaml, b"a: [1\n", "not valid YAML"),
        (read_json, b'{"a": ' * 100_000, "nested too deeply"),
        (read_json, b'{"a": 1, "a": 2}', "'a' appears twice"),
        (read_json, b'{"a": ' + b"9" * 5000 + b"}", "Exceeds the limit"),
        (read_json, b"{", "line 1 column 2"),
        (read_csv, b"a,b\n1,2\n3\n", "line 3 has 1 cells, but the header has 2"),
        (read_csv, b"a,b\n1,2,3\n", "line 2 has 3 cells"),
        (read_csv, b"a,a\n1,2\n", "'a' appears twice"),
        (read_csv, b"", "the file is empty"),
        (read_csv, b'a,b\n"1,2\n', "not a table"),
    ],
)
def test_document_over_the_limits_is_refused(tmp_path, read, content, words):
    path = tmp_path / "document"
    path.write_bytes(content)
    with pytest.raises(InputError, match="document") as caught:
        read(path)
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
    result = invoke(*arguments)
    assert (type(result.exception), result.exit_code) == (SystemExit, 2), result.exception
    return result.stderr


def test_a_bridge_is_only_sought_in_its_folders_and_has_no_number_that_ends_the_solver(tmp_path):
    for name in ("../../etc/passwd", "..", "a/b", "x" * 100_000, "[/red]", "\0"):
        with pytest.raises(InputError, match="bridge must be one of"):
            load_bridge(name)
    (tmp_path / "outside.yaml").write_text("extends: osb1\n", encoding="utf-8")
    (child := tmp_path / "inside" / "mine.yaml").parent.mkdir()
    child.write_text("extends: ../outside\n", encoding="utf-8")
    with pytest.raises(InputError, match="no other bridge"):
        load_bridge(child)
    path = tmp_path / "mine.yaml"
    for value in ("1.0e+300", "1.0e-300", "501.0"):
        path.write_text(f"extends: osb1\nspans_m: {{v: [{value}, 45.0], src: 'd: x'}}\n")
        assert "mine.yaml: spans_m.0: must be" in run("bridge", "modal", "--bridge", path)
    assert "--skew-deg" in run("bridge", "modal", "--skew-deg", "x")


def test_markup_and_control_characters_are_text_and_no_cell_is_a_formula(capsys, tmp_path):
    emit_table([{"[/red]": "[/red] \x1b[31m"}], "[bold]")
    shown = capsys.readouterr().out
    assert ["[/red]" in shown, "[bold]" in shown, "\x1b[31m" in shown] == [True, True, False]
    path = tmp_path / "out.csv"
    write_csv(pd.DataFrame({"name": ["=1+1", "@x", "plain"], "value": [-1.0, 2.0, 3.0]}), path)
    assert path.read_text().splitlines()[1:] == ["'=1+1,-1.0", "'@x,2.0", "plain,3.0"]
    index = tmp_path / "index.csv"
    write_index(index, [{"motion_id": "m", "event": "=cmd()", "magnitude": 7.0}])
    assert "'=cmd()" in index.read_text(encoding="utf-8")


def faults_of(tmp_path, states, raw):
    path = tmp_path / "states.yaml"
    path.write_text(yaml.safe_dump(states), encoding="utf-8")
    raw["fragility"] = {"limit_states": str(path)} | raw.get("fragility", {})
    with pytest.raises(InputError) as caught:
        check_inputs(parse_config(raw))
    return str(caught.value)


def test_all_bad_inputs_of_a_study_are_reported_at_once_also_motions_that_cannot_be_read(tmp_path):
    uncited, certain = ({k: v for k, v in STATE.items() if k != left_out}
                        for left_out in ("citation", "dispersion"))  # fmt: skip
    states = [STATE | {"unit": "kn"}, uncited | {"component": "b"}, certain | {"component": "c"}]
    motions = {"folder": str(tmp_path / "nowhere"), "design": "ida", "ida_demand": "foo_m"}
    raw = {"grid": {"bridge": ["osb9", "osb1"], "gap_mm": [25, 910]}, "motions": motions}
    raw |= {"fragility": {"im": "im_pga"}, "uncertainty": {"enabled": True}}  # offsets to 10 mm
    message = faults_of(tmp_path, states, raw)
    for words in (
        "'osb9'", "osb1: gap_mm must leave some of the left seat of 914 mm, got 920 normal",
        "nowhere does not exist", "fragility.im must be one of", "motions.ida_demand",
        "entry 1: unit", "entry 2: citation: is missing", "entry 3: states.slight.dispersion",
    ):  # fmt: skip
        assert words in message
    assert message.startswith("8 faults:")
    (motions := tmp_path / "motions").mkdir()
    pairs = make_pairs(motions, 2)
    broken = pairs[0][0], pairs[1][1]
    for each in broken:
        each.write_text(each.read_text()[:-40] + " x.y\n")
    state = STATE | {"demand": "nothing_m", "unit": "m"}
    message = faults_of(tmp_path, [state], {"motions": {"folder": str(motions), "count": 2}})
    for words in ("no column 'nothing_m'", broken[0].name, broken[1].name, "3 faults"):
        assert words in message


def run_case(tmp_path, command, case, *, rows=PATH, code=0):
    columns = ["t_s", "ux_m", "uy_m", "uz_m"]
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "path.csv", index=False)
    file = tmp_path / "case.yaml"
    file.write_text(yaml.safe_dump(case) if isinstance(case, dict) else case, encoding="utf-8")
    out = tmp_path / ("f.csv" if command == "contact" else "f.parquet")
    return answer(command, file, "--out", out, code=code)


def test_good_cases_write_forces_and_histories_with_units(tmp_path, caplog):
    slide = [[0, 0, 0, -0.01], [1, 0.1, 0, -0.01]]
    found = run_case(tmp_path, "contact", CONTACT | {"substeps": 100}, rows=slide)
    assert found["friction_work_j"] == pytest.approx(1800 * 0.1 - 1800**2 / 2e5, rel=1e-3)
    run_case(tmp_path, "contact", CONTACT)
    table = pd.read_csv(tmp_path / "f.csv")
    assert list(table.columns) == ["t_s", "fx_n", "fy_n", "fz_n"]
    assert table["fz_n"].tolist() == pytest.approx([1000.0, 1000.0, 0.0])
    # 22 mm from rest is within the elastic slip: the spring force.
    assert table.loc[1, ["fx_n", "fy_n"]].tolist() == pytest.approx([1609.97, 804.98], rel=1e-3)
    case = tmp_path / "case.yaml"
    found = answer("contact", case, "--out", case / "f.csv", code=2)  # below a file
    assert "cannot write" in found["message"]
    found = run_case(tmp_path, "deck", DECK)
    assert "dt_s x contact frequency = 0.14" in caplog.text
    assert set(found["peaks"]) == {"ux_m", "uy_m", "theta_rad", "penetration_m"}
    assert found["first_contact_s"] == pytest.approx(0.0365, abs=1e-3)
    rigid = run_case(tmp_path, "deck", DECK | {"solver": "lcp", "restitution": 0.5})
    assert rigid["peaks"]["penetration_m"] == 0.0
    assert rigid["first_contact_s"] == pytest.approx(found["first_contact_s"], abs=2e-3)
    for command, name in (("contact", "f.parquet"), ("deck", "f.csv")):
        assert f", got {name}" in answer(command, case, "--out", name, code=2)["message"]
    schema = pq.read_schema(tmp_path / "f.parquet")
    assert {"t_s", "ux_m", "theta_rad", "gap_ra_m", "fn_lo_n", "ft_la_n"} <= set(schema.names)
    assert schema.field("fn_ra_n").metadata[b"unit"] == b"N"


@pytest.mark.parametrize(
    ("command", "case", "rows", "word"),
    [
        *(("contact", CONTACT | change, PATH, word) for change, word in BAD["contacts"]),
        *(("deck", DECK | change, PATH, word) for change, word in BAD["decks"]),
        *(("contact", CONTACT, rows, word) for rows, word in BAD["paths"]),
        *(("contact", text, PATH, "case.yaml") for text in ("- 1\n- 2\n", "a: [1\n", "")),
    ],
)  # fmt: skip
def test_wrong_field_or_line_is_named(tmp_path, command, case, rows, word):
    assert word in run_case(tmp_path, command, case, rows=rows, code=2)["message"]
    assert not list(tmp_path.glob("f.*"))


def test_the_checks_before_every_study_pass_and_are_written(tmp_path):
    rows = answer("verify", "gate", "--out", tmp_path)
    table = pd.read_parquet(tmp_path / "gate.parquet")
    tolerances = [row["tolerance"] for row in json.loads((tmp_path / "gate.json").read_text())]
    assert tolerances == pytest.approx(table["tolerance"].tolist(), rel=1e-9, abs=0.0)
    assert table["pass"].all()
    assert len(table) == len(rows) >= 15


@pytest.mark.parametrize(
    ("count", "names"),
    [
        *((34, names) for names in GROUPS),
        (400, RECORDS),
        *(pytest.param(640, names, marks=pytest.mark.slow) for names in GROUPS),
    ],
)
def test_mutant_is_read_or_refused_with_one_message(count, names, tmp_path):
    """A child process reads `count` mutants of each family."""
    with ProcessPoolExecutor(1, get_context("spawn")) as child:
        done = child.submit(mutated_files.read_mutants, names, count, SEED, tmp_path)
    left = [path.name for path in tmp_path.rglob("*") if path.is_file()]
    assert not done.exception(), f"ended at {left}"
    found = pd.DataFrame(done.result()).T
    assert found.loc[found["faults"].astype(bool), "faults"].to_dict() == {}
    assert found["dearest_s"].max() < mutated_files.CPU_LIMIT_S
    assert found["refused"].all()
    assert (found["taken"] + found["refused"]).tolist() == [count] * len(names)
