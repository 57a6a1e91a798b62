"""Wrong case files of `skewbridge contact`, `deck` and `verify`: one clear sentence and exit 2."""

import json

import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

import cli_json
import mutated_files
from mutated_files import CONTACT

DECK = mutated_files.DECK | {"period_theta_s": 0.31623, "gap_normal_m": 0.00269}
PATH = [[0.0, 0.0, 0.0, -0.01], [0.1, 0.02, 0.01, -0.01], [0.2, 0.0, 0.02, 0.01]]


def run(tmp_path, command, case, *, rows=PATH, out=None):
    """Write the files of a case and run its command; return exit code, JSON answer, messages."""
    columns = ["t_s", "ux_m", "uy_m", "uz_m"]
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "path.csv", index=False)
    file = tmp_path / "case.yaml"
    file.write_text(yaml.safe_dump(case) if isinstance(case, dict) else case, encoding="utf-8")
    out = out or tmp_path / ("f.csv" if command == "contact" else "f.parquet")
    return cli_json.run(command, file, "--out", out)


def test_good_contact_case_writes_the_forces(tmp_path):
    code, answer = run(tmp_path, "contact", CONTACT)
    assert code == 0
    table = pd.read_csv(tmp_path / "f.csv")
    assert list(table.columns) == ["t_s", "fx_n", "fy_n", "fz_n"]
    assert table["fx_n"].tolist()[0] == 0.0
    assert table["fz_n"].tolist() == pytest.approx([1000.0, 1000.0, 0.0])
    # 22 mm from rest is within the elastic slip: the spring force.
    assert table.loc[1, ["fx_n", "fy_n"]].tolist() == pytest.approx([1609.97, 804.98], rel=1e-3)
    assert answer["rows"] == 3


def test_good_deck_case_writes_histories_with_units(tmp_path):
    code, answer = run(tmp_path, "deck", DECK)
    assert code == 0
    assert set(answer["peaks"]) == {"ux_m", "uy_m", "theta_rad", "penetration_m"}
    assert answer["first_contact_s"] == pytest.approx(0.0365, abs=1e-3)
    schema = pq.read_schema(tmp_path / "f.parquet")
    assert {"t_s", "ux_m", "theta_rad", "gap_ra_m", "fn_lo_n", "ft_la_n"} <= set(schema.names)
    assert schema.field("fn_ra_n").metadata[b"unit"] == b"N"


WRONG_CONTACT = [
    ({"friction": -0.1}, "friction"),
    ({"tangent_stiffness_n_per_m": 0.0}, "tangent_stiffness_n_per_m"),
    ({"normal_stiffness_n_per_m": "2e7"}, "2.0e+7"),
    ({"normal_stiffness_n_per_m": float("nan")}, "normal_stiffness_n_per_m"),
    ({"gap_m": -0.1}, "gap_m"), ({"scheme": "vectorial"}, "scheme"),
    ({"coupling": "implicit"}, "coupling"), ({"substeps": 0}, "substeps"),
    ({"substeps": 1.5}, "substeps"), ({"colour": "red"}, "colour"),
    ({"path": "nowhere.csv"}, "nowhere.csv"),
]  # fmt: skip
WRONG_DECK = [
    ({"skew_deg": 85.0}, "skew_deg"), ({"mass_kg": 0.0}, "mass_kg"),
    ({"restitution": 1.2}, "restitution"), ({"solver": "magic"}, "solver"),
    ({"integrator": "euler"}, "integrator"), ({"dt_s": 1.0}, "dt_s"),
    ({"pulse": None}, "pulse or motion"), ({"motion": ["a.AT2", "b.AT2"]}, "pulse or motion"),
    ({"pulse": None, "motion": ["a.AT2", "b.AT2"]}, "a.AT2"),
    ({"pulse": {"kind": "sine", "amplitude_g": 0.5, "period_s": 0.5}}, "kind"),
]  # fmt: skip
WRONG_ROWS = [
    ([[0.0, 0, 0, 0], [0.1, float("nan"), 0, 0]], "line 3"),
    ([[0.0, 0, 0, 0], [0.1, 0, 0, 0], [0.1, 0, 0, 0]], "line 4"),
    ([[0.0, 0, 0, 0], [0.2, 0, 0, 0], [0.1, 0, 0, 0]], "must increase"),
    ([[0.0, 0, 0, 0], [0.1, "x", 0, 0]], "ux_m"),
    ([[0.0, 0, 0, 0]], "two rows"),
]


@pytest.mark.parametrize(
    ("command", "case", "rows", "word"),
    [
        *(("contact", CONTACT | change, PATH, word) for change, word in WRONG_CONTACT),
        *(("deck", DECK | change, PATH, word) for change, word in WRONG_DECK),
        *(("contact", CONTACT, rows, word) for rows, word in WRONG_ROWS),
        *(("contact", text, PATH, "case.yaml") for text in ("- 1\n- 2\n", "a: [1\n", "")),
    ],
)
def test_wrong_field_or_line_is_named(tmp_path, command, case, rows, word):
    code, answer = run(tmp_path, command, case, rows=rows)
    assert code == 2
    assert word in answer["message"]
    assert not list(tmp_path.glob("f.*"))


def test_output_folder_that_cannot_be_made_stops_before_any_work(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    code, answer = run(tmp_path, "contact", CONTACT, out=blocked / "f.csv")
    assert code == 2
    assert "cannot write" in answer["message"]


def test_verify_writes_the_table_and_its_json(tmp_path):
    code, rows = cli_json.run("verify", "gate", "--out", tmp_path)
    assert code == 0
    keys = ["study", "quantity", "value", "reference", "tolerance", "pass", "source"]
    assert all(list(row) == keys for row in rows)
    assert pd.read_parquet(tmp_path / "gate.parquet")["pass"].all()
    assert json.loads((tmp_path / "gate.json").read_text())[0]["study"] == "gate"
