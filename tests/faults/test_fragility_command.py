"""`skewbridge fit`: one JSON object, the row of an error, exit codes; tables of other programs."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from cli_json import answer
from fragility_tables import IM, curves_of, states_of, synthetic_demands
from reference_data import BAD
from skewbridge.errors import InputError
from skewbridge.files.tables import read_any
from skewbridge.fragility.demand_table import ColumnMap, prepared, read_foreign
from skewbridge.fragility.fits import fit_cloud
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables

DRIFT = "column_drift_ratio"
RUNS = ("--im", IM, "--edp", DRIFT, "--threshold")
SAME_PLACE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}
TABLE = synthetic_demands(**SAME_PLACE, motions=12)[["motion_id", "status", IM, DRIFT]]
BOTH = {"im": [0.1, 0.2], "n": [20, 20], "k": [1, 2], "edp": [1, 1], "threshold": 1}
NAMED = ("--im", "im", "--edp", "edp", "--threshold", 2)


@pytest.fixture
def fit(tmp_path):
    """Return a function that writes data (JSON, text of a CSV, or a table) and fits them."""

    def call(data, method, *options, refused=None):
        if isinstance(data, pd.DataFrame):
            path = tmp_path / "data.parquet"
            data.to_parquet(path)
        else:
            path = tmp_path / ("data.csv" if isinstance(data, str) else "data.json")
            path.write_text(data if isinstance(data, str) else json.dumps(data), encoding="utf-8")
        given = (path, "--method", method, *options)
        found = answer("fit", *given, code=0 if refused is None else 2)
        assert (refused or "") in found.get("message", "")
        return found

    return call


@pytest.mark.parametrize(
    ("data", "method", "options", "named", "text"),
    [
        *((data, method, (), {"status": "error", "row": row}, text)
          for data, method, row, text in BAD["fits"]),
        # a bad cell in a table of runs
        ("im,edp\n0.1,1\n0.2,2\n0.3,\n0.4,4\n", "cloud", NAMED, {"row": 2, "column": "edp"}, ""),
        ("im,edp\n0.1,1\n0.2,2\n-0.3,3\n0.4,4\n", "cloud", NAMED, {"row": 2, "column": "im"}, ""),
        ({"im": [1, 2, 3], "edp": [1, 2]}, "cloud", NAMED, {}, "columns differ in length"),
        (TABLE.assign(motion_id=[*"abcdefghijk", None]), "cloud", (*RUNS, 0.01),
         {"row": 11, "column": "motion_id"}, "motion_id is missing (row 11)"),
        (TABLE.assign(status="OK"), "cloud", (*RUNS, 0.015), {},
         "status must be one of ok, collapse, numerical_failure, timeout, crash"),
        (TABLE.assign(**{DRIFT: [np.inf, *[0.01] * 11]}), "cloud", (*RUNS, 0.015), {},
         "give a collapsed run the status collapse)"),
        (TABLE, "cloud", ("--im", IM, "--edp", "column_drift", "--threshold", 0.01),
         {"column": "column_drift"},
         f"(did you mean {DRIFT}?); its columns are 'motion_id', 'status'"),
        (TABLE, "cloud", ("--im", "sa", *RUNS[2:], 0.01), {}, "no column 'sa'"),
        *((TABLE.rename(columns={right: name}), "cloud", (*RUNS, 0.015), {},
           f"column {name!r} is not known: did you mean {right}?") for name, right in (
            *((name, "motion_id") for name in ("Motion_ID", "motion id", "motion-id", "motion")),
            ("Status", "status"),
        )),
        # options
        *((BOTH, *given, {}, text) for *given, text in BAD["fit_options"]),
    ],
)  # fmt: skip
def test_bad_data_and_options_exit_two_with_the_reason(fit, data, method, options, named, text):
    found = fit(data, method, *options, refused=text)
    assert found.items() >= named.items()
    assert found.get("row") is None or re.search(r"/data\.(json|csv|parquet): ", found["message"])


def test_spellings_of_published_data_sets_are_understood(fit, tmp_path):
    names = ("right_censored", "censored")
    first, second = (fit({"capacity": [1, 2, 3, 3], name: [0, 0, 0, 1]}, "ida") for name in names)
    assert first == second
    data = {"bracket_lo": [0.4, 0.8, 0.6], "bracket_hi": [0.7, 1.0, "inf"]}
    assert fit(data, "ida")["status"] == "ok"
    assert fit("lower, upper\n0.2, 0.4\n0.5, 0.8\n0.6,\n", "ida")["status"] == "ok"
    counts = pd.DataFrame({"im": [0.2, 0.4, 0.8], "n": [20] * 3, "k": [1, 9, 17]})
    for name, text in (("a.Csv", counts.to_csv()), ("a.JSON", counts.to_json(orient="records"))):
        (tmp_path / name).write_text(text)
        assert answer("fit", tmp_path / name, "--method", "stripes")["status"] == "ok"
    x, y = np.array([0.1, 0.2, 0.5, 0.9]), np.array([0.01, 0.03, 0.05, 0.1])
    logs = {"ln_im": list(np.log(x)), "ln_edp": list(np.log(y)), "threshold": 0.04}
    plain = {"im": list(x), "edp": list(y), "threshold": 0.04}
    named = "--im", "im_exceed", "--edp", "edp"  # a name on the command line is that of the file
    cases = (logs, ()), (plain, ()), ({"im_exceed": plain["im"], **plain}, named)
    thetas = [fit(data, "cloud", *options)["theta"] for data, options in cases]
    assert thetas == pytest.approx([thetas[0]] * 3)
    index = pd.Index(["x", "y"], name="motion_id")  # does not replace a column of its name
    pd.DataFrame({"motion_id": ["b", "a"]}, index).to_parquet(tmp_path / "t.PARQUET")
    assert read_any(tmp_path / "t.PARQUET").to_dict("list") == {"motion_id": ["b", "a"]}
    # a missing method names those of the data
    for data, methods in (
        ({"im": [1], "n": [1], "k": [1]}, "stripes"),
        (BOTH, "stripes or cloud"),
        ({"capacity": [1]}, "ida"),
        ({"im_pga": [1]}, "cloud, stripes or ida, with --im, --edp and --threshold"),
    ):
        (tmp_path / "data.json").write_text(json.dumps(data))
        found = answer("fit", tmp_path / "data.json", code=2)
        assert found["message"] == f"--method is needed; for data.json: {methods}"


def test_a_cloud_is_one_fit_as_arrays_or_as_a_table_with_collapses(fit):
    edp, fall = [*TABLE[DRIFT][:11], np.nan], [0] * 11 + [1]
    arrays = {"im": TABLE[IM].tolist(), "edp": edp, "collapse": fall, "threshold": 0.015}
    table = pd.DataFrame({**arrays, "status": "ok"}).drop(columns="threshold")
    found = fit(arrays, "cloud")
    assert (found, found["method"]) == (fit(table, "cloud", *NAMED[:-1], 0.015), "cloud_tobit")
    assert (found["status"], found["n_censored"]) == ("ok", 1)
    assert "the runs are taken as independent" in found["notes"][0]
    fit(arrays, "cloud", "--model", "ols", refused="would leave out 1 censored demands")
    # only a median of plain arrays may be above all demands
    whole = {"im": TABLE[IM].tolist(), "edp": TABLE[DRIFT].tolist()}
    assert fit(whole | {"threshold": 0.5}, "cloud")["status"] == "ok"
    assert fit(pd.DataFrame(whole), "cloud", *NAMED[:-1], 0.5)["status"] == "no_exceedance"
    # an infinite demand of a collapsed run is no bound
    fallen = TABLE.assign(status=["ok"] * 11 + ["collapse"])
    demands = ([*TABLE[DRIFT][:11], value] for value in (np.nan, np.inf))
    unknown, infinite = (fit(fallen.assign(**{DRIFT: d}), "cloud", *RUNS, 0.015) for d in demands)
    assert (infinite, infinite["status"]) == (unknown, "ok")


def test_a_table_of_runs_obeys_status_and_unknown_outcomes_may_forbid_a_median(fit):
    table = synthetic_demands(**SAME_PLACE)
    table.loc[14, "status"] = "collapse"
    found = fit(table, "cloud", *RUNS, 0.01)
    counts = [found[f"n_{name}"] for name in ("runs", "censored", "records", "unknown")]
    assert counts == [16, 1, 16, 0]
    assert fit(table, "stripes", *RUNS, 0.01)["status"] in {"ok", "complete_separation"}
    found = fit(table.assign(status="ok"), "cloud", *RUNS, 9.0)
    assert (found["status"], found["theta"]) == ("no_exceedance", None)
    assert "of 9 is outside the usual 0.001 to 0.2: check its unit" in "\n".join(found["notes"])
    table = synthetic_demands(**SAME_PLACE, motions=40)
    strong = (table[IM] > 0.3) & (table.index % 2 == 0)
    table.loc[strong, DRIFT] *= 0.5
    table["status"] = np.where(strong, "timeout", "ok")
    found = fit(table, "stripes", *RUNS, 0.015)
    assert (found["status"], found["theta"]) == ("bounds_too_wide", None)
    assert found["n_unknown"] > 2
    assert found["theta_all_exceed"] < found["theta_none_exceed"]
    assert "unknown_outcomes" in found["warnings"]


def test_axes_that_never_change_alone_and_intensities_in_cm_s2_are_noted(fit):
    runs = synthetic_demands(skews=(0, 30), gaps=(25, 51), frictions=(50,))
    states, settings = states_of("unseating")[:1], FitSettings(im=IM)
    together = runs[(runs["skew_deg"] == 30) == (runs["gap_mm"] == 51)]
    for table, names in ((runs, []), (together, ["skew_deg", "gap_mm"])):
        notes = fragility_tables(table, states, settings)["input_notes"]
        assert notes["message"].tolist() == [
            f"{name} never changes alone: its effect cannot be separated" for name in names
        ]
    given = ("--im", "pga", "--edp", DRIFT, "--threshold", 0.015)
    for factor in (1.0, 981.0):
        notes = fit(TABLE.assign(pga=factor * TABLE[IM]), "cloud", *given)["notes"]
        assert any(note.endswith("g is needed, not cm/s2") for note in notes) == (factor > 1.0)


def test_intervals_are_by_motion_or_event_where_motions_repeat(fit):
    table = synthetic_demands(**SAME_PLACE, motions=24, scales=(0.6, 1.0, 1.6))
    plain = fit(table, "cloud", *RUNS, 0.015)
    codes = np.unique(table["motion_id"], return_inverse=True)[1]
    wide = fit_cloud(table[IM], table[DRIFT], 0.015, capacity_dispersion=0.5, motions=codes)
    assert wide.beta == pytest.approx(np.hypot(plain["beta"], 0.5 / plain["b"]))
    assert wide.ci_beta[0] > plain["ci_beta"][1]
    stripes = fit(table, "stripes", *RUNS, 0.015)
    assert wide.ci_method == plain["ci_method"] == stripes["ci_method"] == "jackknife"
    assert stripes["n_records"] == 24
    ida = fit(table, "ida", *RUNS, 0.015)
    assert (ida["method"], ida["n_runs"]) == ("ida_interval", 24)
    for method in ("stripes", "cloud"):
        (note,) = fit(table.iloc[1:], method, *RUNS, 0.015)["notes"]
        assert note.startswith("motions have different levels")
    # runs of one event are left out together, and those of one motion have no interval
    found = fit(TABLE.assign(event=[*"aabbccddee", "", ""]), "cloud", *RUNS, 0.01)
    assert (found["ci_method"], found["n_records"]) == ("jackknife", 12)
    joined = TABLE.assign(motion_id=[*"aabbccddeefg"]).rename(columns={"motion_id": "GM-ID"})
    assert found["ci_theta"] == fit(joined, "cloud", *RUNS, 0.01)["ci_theta"]
    one = fit(TABLE.assign(motion_id="a"), "cloud", *RUNS, 0.01)
    assert one["theta"] == pytest.approx(found["theta"])
    assert (one["ci_theta"], one["ci_method"]) == ([None, None], "")
    assert "too_few_motions_for_an_interval" in one["warnings"]


@pytest.mark.parametrize("method", ["cloud", "stripes", "ida"])
@pytest.mark.parametrize("levels", [["motion_id"], ["motion_id", "scale"], [DRIFT, IM], [IM]])
def test_a_named_index_is_read_as_columns(fit, method, levels):
    table = synthetic_demands(**SAME_PLACE, motions=24, scales=(0.6, 1.0, 1.6))
    table = table[["motion_id", "scale", IM, DRIFT, "status"]]
    expected = fit(table, method, *RUNS, 0.015)
    found = fit(table.set_index(levels), method, *RUNS, 0.015)
    assert (found, found["n_records"], found["notes"]) == (expected, 24, [])


def test_medians_that_rest_on_the_definition_of_collapse_are_withheld(fit):
    runs = synthetic_demands(skews=(0,), gaps=(25,), frictions=(50,), motions=40)
    for level, status in ((0.45, "bounds_too_wide"), (0.9, "ok")):  # every stronger run collapses
        fall, peaks = runs[IM] > level, runs["unseating_m"]
        cut = runs.assign(status=np.where(fall, "collapse", "ok"), unseating_m=peaks.mask(fall))
        curves = curves_of(cut, states_of("unseating"))
        # all runs give 0.236 and 0.749; the larger capacities pull even the first to 0.307
        assert set(curves.query("method == 'cloud'")["status"][:2]) == {status}
        data = {"im": list(runs[IM]), "edp": list(peaks.where(~fall, 0.0)), "threshold": 0.114}
        assert fit(data | {"collapse": fall.astype(int).tolist()}, "cloud")["status"] == status


@pytest.mark.parametrize(
    ("column", "is_cut"),
    [("censored", [1, 0]), ("complete", [False, True]), ("right_censored", [1, 0]),
     ("beyond_model", ["shear", ""])],
)  # fmt: skip
def test_a_flag_censors_the_demands_of_a_table_of_runs(fit, column, is_cut):
    demand = np.minimum(TABLE[DRIFT], 0.014)
    columns = {DRIFT: demand, column: np.where(demand == 0.014, *is_cut)}
    found = fit(TABLE.assign(**columns), "cloud", *RUNS, 0.01)
    assert (found["n_censored"], found["method"]) == ((demand == 0.014).sum(), "cloud_tobit")


def test_unused_and_repeated_rows_of_a_table_of_runs_are_reported(fit):
    (note,) = fit(pd.concat([TABLE, TABLE]), "cloud", *RUNS, 0.01)["notes"]
    assert note.startswith("12 runs repeat intensity and demand of another run: intervals are too")
    # two variants under one motion, collapsed without a demand
    several = pd.concat([TABLE.assign(skew_deg=skew, collapse=0) for skew in (0, 30)])
    several[DRIFT] *= 1.0 + 0.01 * several["skew_deg"]
    several.loc[several["motion_id"] == "m11", ["collapse", DRIFT]] = 1, np.nan
    assert fit(several, "cloud", *RUNS, 0.01)["notes"] == ["one curve for all values of 'skew_deg'"]
    unhashable = TABLE.assign(more=[[1]] * 12).to_dict("list")
    assert fit(unhashable, "cloud", *RUNS, 0.01)["notes"] == ["columns that are not used: 'more'"]


def test_censored_high_demands_of_a_straight_cloud_do_not_look_saturating():
    rng, names = np.random.default_rng(1), []
    for _ in range(60):
        im = np.exp(rng.uniform(-2.3, 0.4, 80))
        edp = 0.02 * im**1.1 * np.exp(0.35 * rng.normal(size=80))
        upper = np.where(edp > 0.015, np.inf, edp)  # a quarter of the demands
        names += fit_cloud(im, np.minimum(edp, 0.015), 0.012, upper).warnings
    # a test at 5 % warns in 3 of 60 clouds; the regression of the other demands warned in 20
    assert sum(name in {"saturating", "curved"} for name in names) <= 8
    bent = 0.02 * np.exp(1.1 * np.log(im) - 0.5 * np.log(im) ** 2 + 0.1 * rng.normal(size=80))
    upper = np.where(bent > 0.015, np.inf, bent)
    assert "saturating" in fit_cloud(im, np.minimum(bent, 0.015), 0.012, upper).warnings


def test_foreign_tables_lose_single_bad_rows_or_are_refused_with_row_and_column(tmp_path):
    def foreign(data, names):
        pd.DataFrame(data).to_csv(path := tmp_path / "theirs.csv", index=False)
        return read_foreign(path, read_any(path), ColumnMap(columns=names))

    data = {"record": [*"abc"], "PGA": [0.1, 0.2, 0.3], "end": ["ok", "collapse", "ok"],
            "failed": ["", "", "shear"], "all": [True, True, False]}  # fmt: skip
    names = {"motion_id": "record", "im_pga_g": "PGA", "status": "end", "beyond_model": "failed"}
    assert foreign(data, names)["complete"].tolist() == [True, False, False]
    assert foreign(data, names | {"complete": "all"})["complete"].tolist() == data["all"]
    partly = foreign(data | {"all": [None, 1, 0]}, names | {"complete": "all"})
    assert partly["complete"].tolist() == data["all"]
    table = synthetic_demands(**SAME_PLACE, motions=30)[["motion_id", "status", IM, DRIFT]]
    table.loc[3, IM] = np.nan
    table.loc[7, DRIFT] = np.nan
    ours = prepared(foreign(table, {name: name for name in table}), [DRIFT], FitSettings(im=IM))
    kinds = ours.notes[["kind", "row"]].to_numpy().tolist()
    assert kinds == [["rejected_row", 3], ["missing_demand", 7]]
    row = curves_of(ours.table, states_of("column_drift")[:1]).iloc[0]
    assert (row["status"], row["n_runs"]) == ("ok", 29)
    data = {"record": ["a", "b"], "PGA": [0.1, 0.2], "drift": ["0.1", "0.2"], "status": ["ok"] * 2}
    columns = {"motion_id": "record", "im_pga_g": "PGA", DRIFT: "drift", "status": "status"}
    repeated = {"record": ["a", "a"], "PGA": [0.2, 0.2]}
    # a motion at several intensities was scaled
    assert foreign(data | {"record": ["a", "a"]}, columns)["scale"].tolist() == [1.0, 2.0]
    for change, text in (
        ({"PGA": [0.1, np.inf]}, "im_pga_g must be > 0 and finite (row 1); got inf"),
        ({"drift": ["1", "much"]}, "drift must be a number, got 'much' (row 1)"),
        ({"status": ["ok", "fine"]}, "invalid_input, got 'fine' (row 1)"),
        ({"record": ["a", "a"], "event": ["x", "y"]}, "motion 'a' has several events: give it"),
        (repeated, "remove it, or add 'scale', 'incidence_deg' if the runs differ"),
        (repeated | {"angle": [0, 9]}, "use a column as axis: 'angle'"),
        ({"Skew_deg": [0, 60]}, "column 'Skew_deg' is not known: did you mean skew_deg?"),
        ({"Skew (deg)": [0, 60]}, "column 'Skew (deg)' is not known: did you mean skew_deg?"),
        ({"gap_m": [0, 1]}, "did you mean gap_mm? Convert to mm, rename or map the column"),
        ({"scale": [1, 2]}, "column scale must be mapped, or given as a constant"),
        ({"variant": ["A", "B"]}, "variants 'A', 'B' have the same bridge, abutment and axes"),
        ({"record": ["a", None]}, "record is missing (row 1)"),
    ):
        with pytest.raises(InputError, match=re.escape(text)):
            foreign(data | change, columns | {n: n for n in change if n in ("variant", "event")})


def test_a_foreign_table_is_fitted_by_its_file_of_columns(fit, tmp_path):
    table = synthetic_demands(**SAME_PLACE, motions=30)
    theirs = pd.DataFrame({"rec": table["motion_id"], "sa": table[IM], "pct": 100 * table[DRIFT]})
    columns = tmp_path / "columns.yaml"
    text = f"columns: {{motion_id: rec, {IM}: sa, column_drift_ratio: pct}}\n"
    columns.write_text(text + "factors: {column_drift_ratio: 0.01}\n", encoding="utf-8")
    ours = fit(table, "cloud", *RUNS, 0.02)
    found = fit(theirs.to_csv(), "cloud", *RUNS, 0.02, "--columns", columns)
    assert found["theta"] == pytest.approx(ours["theta"])
    counts = pd.DataFrame({"sa": [200.0, 400.0, 800.0], "fell": [1, 6, 11], "runs": 12})
    columns.write_text("columns: {im: sa, k: fell}\nfactors: {im: 0.001}\nconstants: {n: 12}\n")
    mapped = fit(counts.to_csv(), "stripes", "--columns", columns)
    plain = fit({"im": [0.2, 0.4, 0.8], "n": [12] * 3, "k": [1, 6, 11]}, "stripes")
    assert (mapped["theta"], mapped["n_runs"]) == (pytest.approx(plain["theta"], rel=1e-9), 36)
    columns.write_text("column: {}\n", encoding="utf-8")
    fit(theirs.to_csv(), "cloud", *RUNS, 0.02, "--columns", columns, refused="columns.yaml")
    for text, words in (
        ("factors: {column_drift: 0.01}", "factors: 'column_drift' is not a key of columns"),
        ("constants: {motion_id: a}", "constants: 'motion_id' is also in columns"),
    ):
        columns.write_text(f"columns: {{motion_id: rec, {IM}: sa, {DRIFT}: pct}}\n{text}\n")
        fit(theirs.to_csv(), "cloud", *RUNS, 0.02, "--columns", columns, refused=words)
