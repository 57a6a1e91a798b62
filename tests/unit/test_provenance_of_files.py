"""Every artefact has its provenance and is known to be current or not; `skewbridge.load`."""

import errno
import json
import logging
import os
import platform
import signal
import warnings
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pyarrow as pa
import pytest
from matplotlib.figure import Figure

import skewbridge
from cli_json import run
from skewbridge.cli.output import study_of
from skewbridge.errors import InputError, SolutionError
from skewbridge.files import digests, tables
from skewbridge.files.text import merged, read_mapping
from skewbridge.study import jobs
from skewbridge.study.config import load_config, parse_config, store_configuration
from skewbridge.study.jobs import RECIPES, made_from, rule_digest, script_session

ROOT = Path(__file__).parents[2]
STAMP = {"rule": "fit_fragility", "title": 'a <script> & "quotes"', "rule_digest": "0" * 16}
FRAME = pd.DataFrame({"theta": [0.5, 0.7]})
RULE = "collect_demands"
READ_ONLY = (errno.EROFS, "Read-only file system")
ROUNDS = {"plan_round", "collect_rounds"}  # their plans read the new demands
FITS = {"fit_fragility", "figures", "report"} | ROUNDS
NOT_OF_MOTIONS = {"verify_contact", "verification"}
NOT_OF_MODEL = {"prepare_motions"} | NOT_OF_MOTIONS | ROUNDS
pytestmark = pytest.mark.usefixtures("in_the_repository")


def artefact(folder: Path, ending: str, metadata: dict[str, str] | None = None) -> Path:
    """Write a small file of each kind; figures have their provenance when they are saved."""
    path = folder / f"file{ending}"
    if ending == ".parquet":
        tables.write_frame(FRAME, path, {"made_for": "another digest"})
    elif ending == ".json":
        path.write_text('{"passed": true}')
    elif ending == ".html":
        path.write_text('<!doctype html>\n<html lang="en"><head>\n<title>t</title></head></html>')
    else:
        Figure(figsize=(1, 1)).savefig(path, metadata=tables.figure_metadata(metadata or {}))
    return path


@pytest.mark.parametrize("ending", [".parquet", ".json", ".html"])
def test_a_later_stamp_replaces_an_earlier_one_and_keeps_the_content(tmp_path, ending):
    path = artefact(tmp_path, ending)
    older = {"rule": "an older one, longer than the newer"}
    tables.stamp(path, older)
    once = path.stat().st_size
    tables.stamp(path, STAMP)
    assert STAMP.items() <= tables.read_stamp(path).items()
    tables.stamp(path, older)
    assert tables.read_stamp(path)["rule"] == older["rule"]
    if ending == ".parquet":  # there, names that are not given again stay
        assert tables.read_stamp(path)["made_for"] == "another digest"
        pd.testing.assert_frame_equal(tables.read_frame(path), FRAME)
    else:
        assert path.stat().st_size == once
    if ending == ".json":
        assert json.loads(path.read_text())["passed"]


@pytest.mark.parametrize("ending", [".svg", ".png"])
def test_a_figure_has_its_provenance_in_the_metadata_of_its_format(tmp_path, ending):
    path = artefact(tmp_path, ending, STAMP)
    before = path.read_bytes()
    tables.stamp(path, {"rule": "another"})
    assert path.read_bytes() == before
    assert tables.read_stamp(path) == STAMP


def test_files_without_metadata_are_left_as_they_are_and_missing_or_broken_ones_named(tmp_path):
    for name in ("rows.csv", "list.json"):
        (path := tmp_path / name).write_text("[1, 2]")
        tables.stamp(path, STAMP)
        assert path.read_text() == "[1, 2]"
        with pytest.raises(InputError, match="has no provenance"):
            tables.read_stamp(path)
    for name in ("no.parquet", "no.csv", "broken.parquet", "broken.json"):
        (tmp_path / f"broken{Path(name).suffix}").write_text("{{")
        with pytest.raises(InputError, match=name):
            tables.read_stamp(tmp_path / name)


def test_machine_and_commit_are_described_without_other_names(tmp_path, monkeypatch):
    machine = digests.provenance()
    assert {"git_commit", "git_dirty", "processor", "processors"} <= set(machine)
    assert not any(name in json.dumps(machine) for name in (platform.node(), str(Path.cwd())))
    # nor by the commit of a repository in which the package is installed
    monkeypatch.setattr(digests, "PACKAGE", tmp_path / "lib/python3/site-packages/skewbridge")
    digests.PACKAGE.mkdir(parents=True)
    os.system(f"git init -q '{tmp_path}'")
    assert digests._git.__wrapped__("rev-parse", "--git-dir") is None


class Named(dict):
    """Outputs as Snakemake has them: a list of paths whose items have names."""

    def __iter__(self):
        return iter(self.values())


def job(folder: Path, table: Path, **made: str) -> SimpleNamespace:
    """What Snakemake gives the script of a rule."""
    made_from = {"sources": digests.layer_digest(RECIPES[RULE].sources), "motions": "suite", **made}
    return SimpleNamespace(
        rule=RULE, threads=1, log=[folder / "rule.log"], input={}, output=Named(table=str(table)),
        config=merged(read_mapping(ROOT / "config/config.yaml"), {"motions": {"count": 3}}),
        params=SimpleNamespace(results=str(folder), made_from=made_from),
    )  # fmt: skip


def test_a_script_stamps_its_outputs_and_leaves_a_log_only_of_messages(tmp_path):
    table, log = tmp_path / "table.parquet", tmp_path / "rule.log"
    given = job(tmp_path, table, suspect="x")
    with script_session(given) as own:
        assert (own.outputs, own.folder.root) == ({"table": table}, tmp_path)
        tables.write_frame(FRAME, table, {})
    stamped = tables.read_stamp(table)
    expected = {"rule_digest": rule_digest(given.params.made_from), "suite_digest": "suite"}
    assert {name: stamped[name] for name in (*expected, "git_commit")}.items() > expected.items()
    for message in ("17 rows left out", ""):
        with script_session(job(tmp_path, table)):
            tables.write_frame(FRAME, table, {})
            if message:
                logging.getLogger("skewbridge.fit").info(message)
        assert log.exists() == bool(message)


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (InputError("bad input"), 2, "bad input\n"),
        (SolutionError("checks failed"), 1, "checks failed\n"),
        (None, 130, "interrupted; finished analyses are kept: repeat the command to resume\n"),
        (OSError(*READ_ONLY, "/a/disk"), 2, f"cannot read or write /a/disk: {READ_ONLY[1]}; "),
        (OSError(*READ_ONLY), 2, f"cannot read or write the results in {{}}: {READ_ONLY[1]}; "),
    ],
)
def test_a_failed_script_ends_with_its_message_and_code(tmp_path, capsys, error, code, message):
    # A shell starts background processes with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def fail():
        if error:
            raise error
        os.kill(os.getpid(), signal.SIGINT)

    def stopped(given, begun):
        with pytest.raises(SystemExit) as caught, script_session(given):
            begun()
        return caught.value.code, capsys.readouterr().err

    found, printed = stopped(job(tmp_path, tmp_path / "none.parquet"), fail)
    signal.signal(signal.SIGINT, before)
    assert (found, len(printed.splitlines())) == (code, 1)
    assert printed.startswith(message.format(tmp_path))
    # nor does it begin if its sources are others than those of the plan
    edited = job(tmp_path, tmp_path / "none.parquet", sources="as they were")
    found, printed = stopped(edited, lambda: pytest.fail("it began"))
    assert (found, "sources were edited while the study ran" in printed) == (2, True)


def test_a_file_is_compared_with_the_configuration_of_its_own_study(tmp_path, monkeypatch):
    monkeypatch.setattr(jobs, "made_from", lambda s: {RULE: {"motions": "m", "n": s.motions.count}})
    (tmp_path / "config").mkdir()
    monkeypatch.chdir(tmp_path)
    base, mine = tmp_path / "config/config.yaml", tmp_path / "elsewhere.yaml"
    base.write_text("motions: {count: 32}\nfigures: {width_mm: 60}\n")
    mine.write_text("motions: {count: 3}\n")
    given = {"figures": {"width_mm": 85.0}}
    table = tmp_path / "some/results/demands/table.parquet"

    def compared():
        code, answer = run("provenance", table)
        return [code, answer["current"], answer["differences"]]

    study = parse_config({"results": "some/results", "motions": {"count": 3}, **given})
    tables.write_frame(FRAME, table, jobs.stamp_of(RULE, jobs.made_from(study)[RULE], study))
    store_configuration(study, [base, mine], given)
    assert compared() == [0, True, []]
    base.write_text("motions: {count: 8}\nfigures: {width_mm: 70}\n")  # both are overridden
    assert compared() == [0, True, []]
    mine.write_text("motions: {count: 4}\n")
    assert compared() == [1, False, ["rule_digest", "config_digest"]]
    mine.unlink()
    assert compared() == [0, True, []]
    assert study_of(Path("some/results")).motions.count == 3
    monkeypatch.chdir(base.parent)
    assert f"run the command in {tmp_path}" in run("provenance", table)[1]["message"]
    monkeypatch.chdir(tmp_path)
    stored = tmp_path / "some/results/configuration.json"
    stored.write_text(stored.read_text().replace('"file": null', '"file": null, "measure": "x"'))
    with pytest.raises(InputError, match=r"an earlier version, .*lacks: hazard\.measure\. Remove"):
        study_of(Path("some/results"))
    stored.unlink()  # of an earlier version still
    assert compared()[:2] == [1, False]
    (tmp_path / "config/third.yaml").write_text("results: some/results\nmotions: {count: 3}\n")
    assert compared() == [0, True, ["config_digest"]]


def test_a_result_of_one_run_is_current_while_the_engine_is(tmp_path):
    path = tmp_path / "histories.parquet"
    for digest, code in ((digests.engine_digest(), 0), ("of older sources", 1)):
        tables.write_frame(FRAME, path, digests.provenance(run_key="k", engine_digest=digest))
        assert run("provenance", path)[0] == code
    tables.write_frame(FRAME, path, digests.provenance())
    code, answer = run("provenance", path)
    assert (code, "`skewbridge statistics`" in answer["message"]) == (2, True)
    assert run("provenance", tmp_path / "none.png")[0] == 2


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("", set()), ("batches: {no_progress_s: 7}", set()), ("fragility: {margin: 0.07}", FITS),
        ("figures: {width_mm: 85}", {"figures", "report"}),
        ("sensitivity: {rows: 1}", {"sensitivity", "report"}),
        ("model: {cohesion_n: 5.0}", set(RECIPES) - NOT_OF_MODEL),
        ("motions: {level_range_g: [0.1, 2.0]}", set(RECIPES) - NOT_OF_MOTIONS),
    ],
)  # fmt: skip
def test_a_key_of_the_configuration_changes_the_rules_that_use_it(tmp_path, text, changed):
    base = tmp_path / "base.yaml"
    default = read_mapping(ROOT / "config/config.yaml")
    base.write_text(json.dumps(merged(default, {"motions": {"count": 2}})))

    def studied(text: str) -> dict[str, dict[str, str]]:
        config = tmp_path / "mine.yaml"
        config.write_text(f"results: {tmp_path}/results\n{text}")
        return made_from(load_config(config, base=base))

    before, after = studied(""), studied(text)
    assert {rule for rule in before if before[rule] != after[rule]} == changed


def test_a_title_changes_the_page_alone_another_solver_all_but_motions(monkeypatch, tmp_path):
    own, found = tmp_path / "own.yaml", []
    for title in ("one", "two"):
        own.write_text(f"{{extends: osb1, title: {title}, source: plan}}")
        found.append(made_from(parse_config({"grid": {"bridge": [str(own)]}})))
    assert {rule for rule in RECIPES if found[0][rule] != found[1][rule]} == {"report"}
    before = made_from(parse_config({}))
    monkeypatch.setattr(digests, "version", {"openseespy": "9.9"}.get)
    monkeypatch.setattr(jobs, "opensees_version", digests.opensees_version.__wrapped__)
    after = made_from(parse_config({}))
    assert {rule for rule in RECIPES if before[rule] == after[rule]} == {"prepare_motions"} | ROUNDS


def test_frames_have_units_and_origin_and_different_origins_are_reported(tmp_path):
    unit = pa.field("column_shear_kn", pa.float64(), metadata={"unit": "kN"})
    schema = pa.schema([unit], metadata={"config_digest": "abc"})
    tables.write_table(pa.table([[1.0]], schema=schema), tmp_path / "demands.parquet")
    curve = {"skew_deg": 30.0, "im": "im_pga_rotd50_g", "theta": 0.5, "theta_low": 0.4}
    (path := tmp_path / "fragility/curves.parquet").parent.mkdir()
    tables.write_frame(pd.DataFrame([curve]), path, {"config_digest": "abc"})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = skewbridge.load(tmp_path)
    assert repr(found) == f"Results({tmp_path}: 1 runs; curves)"
    assert found.demands.attrs["units"] == {"column_shear_kn": "kN"}
    curves = found.fragility["curves"]
    assert curves.attrs["units"] == {"skew_deg": "deg", "theta": "g", "theta_low": "g"}
    assert curves.attrs["provenance"]["config_digest"] == "abc"
    tables.write_frame(pd.DataFrame([curve]), path, {"config_digest": "xyz"})
    with pytest.warns(UserWarning, match=r"config_digest abc \(demands\), xyz \(curves\)"):
        skewbridge.load(tmp_path)
    with pytest.raises(InputError, match=r"no demands\.parquet"):
        skewbridge.load(tmp_path / "fragility")
