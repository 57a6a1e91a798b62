"""The commands `skewbridge motions ...` and the pictures, from outside."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from cli_json import answer, invoke
from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.motions.intensity import IM_COLUMNS
from skewbridge.motions.suite import prepare_suite
from skewbridge.report.run_figures import suite_spectra


def _run(*arguments: object) -> tuple[int, str, str]:
    result = invoke("motions", *arguments)
    return result.exit_code, result.stdout, result.stderr


def _checked(*arguments: object) -> tuple[int, dict, str]:
    code, out, err = _run("check", *arguments, "--json")
    return code, json.loads(out), err


@pytest.mark.parametrize(
    ("content", "verdict", "codes"),
    [
        (at2_text(shaken_g(1)), "ok", (0, 0)), (at2_text(shaken_g(1) - 0.05), "warn", (0, 2)),
        (at2_text(1e4 * shaken_g(1)), "error", (2, 2)),
        ("\n".join(map(str, shaken_g(1))), "needs_dt", (2, 2)),
    ],
)  # fmt: skip
def test_check_has_the_documented_keys_and_exit_codes(tmp_path, content, verdict, codes):
    path = tmp_path / "a.txt"
    path.write_text(content)
    code, checked, _ = _checked(path)
    (found,) = checked["files"]
    assert set(found) == {"file", "verdict", "format", "dt_s", "npts", "pga_g", "messages"}
    assert (found["verdict"], code, _run("check", path, "--strict")[0]) == (verdict, *codes)
    assert ("the mean is 1" in str(found["messages"])) == (verdict == "warn")
    if verdict == "ok":
        assert (found["dt_s"], found["npts"]) == (0.01, 400)
        assert found["pga_g"] == pytest.approx(0.3, rel=1e-6)


def test_check_writes_an_index_that_the_study_reads(tmp_path):
    make_pairs(tmp_path, 2)
    assert _checked(tmp_path, "--write")[0] == 0
    index, suite = pd.read_csv(tmp_path / "index.csv"), prepare_suite(tmp_path, t1_s=0.7)
    assert list(index["motion_id"]) == ["q0", "q1"]
    assert list(index["sha256"]) == list(suite["sha256"])
    for number, file in enumerate((tmp_path / "q0_h1.AT2", tmp_path / "q0_h2.AT2"), 1):
        file.rename(tmp_path / f"(50 %) #1's_h{number}.AT2")
    (tmp_path / "index.csv").unlink()
    assert _run("check", tmp_path, "--write")[0] == 0
    assert prepare_suite(tmp_path, t1_s=0.7)["motion_id"][0] == "_(50 _) _1_s"
    # with the time step and unit that were given, and no unit that was assumed
    (bare := tmp_path / "bare").mkdir()
    for name in ("q_h1.acc", "q_h2.acc"):
        (bare / name).write_text("\n".join(map(str, 5.0 * shaken_g(3))))
    assert [_run("check", bare, "--write", *dt)[0] for dt in ((), ("--dt-s", 0.005))] == [2, 0]
    assert pd.read_csv(bare / "index.csv")["unit"].isna().all()
    assert _run("check", bare, "--write", "--dt-s", 0.005, "--unit", "m/s2")[0] == 0
    (motion,) = prepare_suite(bare, t1_s=0.7).to_dict("records")
    assert (motion["dt_s"], round(np.abs(motion["accel_1_mps2"]).max(), 6)) == (0.005, 1.5)
    # the unit of one file would be that of the other
    for name in ("index.csv", "q_h1.acc"):
        (bare / name).unlink()
    (bare / "q_h1.AT2").write_text(at2_text(shaken_g(1), 0.005))
    code, _, err = _run("check", bare, "--write", "--dt-s", 0.005, "--unit", "m/s2")
    assert (code, "q: files in g and m/s2, but an index row has one unit" in err) == (2, True)


def test_check_names_and_counts_the_files_that_were_not_read(tmp_path):
    index_of(tmp_path, make_pairs(tmp_path, 1))
    others = ["a.mseed", "b.sac", "c.xlsx", "deep/d.rec", "e.zip", "f.txt"]
    notes = ["notes.md", "q0_h1.VT2"]  # and the velocity of an acceleration
    (tmp_path / "deep").mkdir()
    for name in (*others, *notes):
        (tmp_path / name).write_text("no motion\n")
    code, found, err = _checked(tmp_path)
    unread = {item["file"] for item in found["files"] if item["verdict"] == "not_read"}
    assert unread == {str(tmp_path / name) for name in others}
    assert (code, found["not_read"], len(found["files"])) == (0, 8, 10)
    assert all(words in err for words in ("8 files were not read", *others, *notes))
    assert _run("check", tmp_path, "--strict")[0] == 2
    for name in others:
        (tmp_path / name).unlink()
    assert _run("check", tmp_path, "--strict")[0] == 0


def test_check_warns_of_one_component_twice_and_names_vertical_ones(tmp_path):
    (first, second), *_ = make_pairs(tmp_path, 1)
    for copy in (second, tmp_path / f"q0-UP{first.suffix}"):
        shutil.copy(first, copy)
    code, found, _ = _checked(tmp_path)
    found = {Path(item["file"]).stem: item for item in found["files"]}
    assert (code, _run("check", tmp_path, "--strict")[0]) == (0, 2)
    verdicts = {name: item["verdict"] for name, item in found.items()}
    assert verdicts == {"q0_h1": "warn", "q0_h2": "warn", "q0-UP": "ok"}
    assert "Both components have the same values" in " ".join(found["q0_h2"]["messages"])
    assert found["q0-UP"]["messages"][-1] == "vertical component: a study does not use it"


def test_unit_option_applies_only_to_files_without_a_unit(tmp_path):
    make_pairs(tmp_path, 1)
    text = "\n".join(f"{0.01 * n:.2f},{a:.6e}" for n, a in enumerate(980.665 * shaken_g(3)))
    for name in ("valley_000.csv", "valley_090.csv"):
        (tmp_path / name).write_text(text)
    code, found, _ = _checked(tmp_path)
    assert (code, "--unit" in str(found["files"])) == (2, True)
    alone = {item["file"]: item["pga_g"] for item in found["files"] if item["pga_g"]}
    code, found, _ = _checked(tmp_path, "--write", "--unit", "cm/s2")
    assert code == 0
    assert alone.items() <= {item["file"]: item["pga_g"] for item in found["files"]}.items()
    assert list(pd.read_csv(tmp_path / "index.csv")["unit"]) == ["g", "cm/s2"]


def test_check_compares_files_with_their_index(tmp_path):
    pairs = make_pairs(tmp_path, 1)
    index_of(tmp_path, pairs, sha256=["f" * 64], magnitude=[6.9], my_note=["mine"])
    code, found, _ = _checked(tmp_path)
    assert (code, "sha256" in found["files"][0]["messages"][-1]) == (2, True)
    assert [_run("check", tmp_path, *option)[0] for option in (["--write"], [])] == [0, 0]
    row = pd.read_csv(tmp_path / "index.csv").iloc[0]
    assert (row["magnitude"], row["my_note"]) == (6.9, "mine")  # the rest is kept


def test_im_json_has_the_documented_measures_of_a_pair_or_a_file(tmp_path):
    files = make_pairs(tmp_path, 1)[0]
    found = answer("motions", "im", *files, "--t1-s", 0.7)
    assert all(found[name] > 0 for name in (*IM_COLUMNS, "pga_h1_g", "pga_h2_g"))
    row = prepare_suite(tmp_path, t1_s=0.7).iloc[0]
    assert found["im_saavg_rotd50_g"] == pytest.approx(row["im_saavg_rotd50_g"])
    assert answer("motions", "im", *files)["im_saavg_rotd50_g"] is None
    assert "-: needs --t1-s" in _run("im", *files)[2]
    assert _run("im", *files, files[0])[0] == 2
    index_of(tmp_path, [files])
    assert "index.csv lists motions" in _run("im", tmp_path / "index.csv")[2]
    assert _checked(tmp_path / "index.csv")[1]["files"][0]["verdict"] == "ok"
    found = answer("motions", "im", files[0])
    assert found["pga_h1_g"] == pytest.approx(0.3, rel=1e-6)
    assert len(found["psa_h1_g"]) == len(found["periods_s"]) > 20


def test_plot_draws_a_motion_or_the_spectra_of_a_folder(tmp_path):
    files, picture = make_pairs(tmp_path, 3)[0], tmp_path / "figures" / "q0.png"
    assert answer("motions", "plot", *files, "--out", tmp_path / "figures")["file"] == str(picture)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert _run("plot", tmp_path, "--out", tmp_path / "suite.svg")[0] == 0
    assert (tmp_path / "suite.svg").read_text().count("<path") > 10
    figure = suite_spectra(np.array([[1.0, 1.0], [8.0, 8.0], [1.0, 1.0]]), [0.1, 1.0], title="")
    assert figure.axes[0].lines[3].get_ydata() == pytest.approx([2.0, 2.0])  # the median is 1


def test_synthesized_suite_passes_the_check_and_keeps_earlier_motions(tmp_path):
    scenario = ("--magnitude", 6.5, "--distance-km", 10, "--vs30-mps", 400, "--seed", 5)
    for count, name in ((1, "one"), (2, "two")):
        assert _run("synthesize", *scenario, "--count", count, "--out", tmp_path / name)[0] == 0
    assert _run("check", tmp_path / "two", "--strict")[0] == 0
    for name in ("syn001_h1.AT2", "syn001_h2.AT2"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
