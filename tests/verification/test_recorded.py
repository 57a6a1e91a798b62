"""An instrumented bridge: files of its station, identified periods, and the stored comparison."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from cli_json import invoke, run
from motions_files import rows_of
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.verification.registry import run_study
from skewbridge.verification.studies.recorded import (
    identified_period,
    in_band,
    read_events,
    read_station,
    strong_part,
)

ROOT = Path(__file__).parents[2]
DT_S = 0.01
HEADER = """Corrected accelerogram   {station}-X       Chan {recorder:2d}:  {direction}   from
Uncorrected Accelerogram Data             Processed: 02/03/15
Rcrd of Wed Jan 28, 2015 13:08:38.0 PST
Processing
{station}-X
Station No. {station}   40.503N, 124.101W    (17 Chns of 17 at Sta)
Rio Dell - Hwy 101/Painter St. Overpass
Chan {recorder:2d}:  {direction}    (Sta Chn: {channel:2d})     Location: On Ground
 {count} points of accel data equally spaced at  {dt:.3f} sec.  (Units: cm/sec/sec)
"""
GROUND = (1, 3, 15, 17, 18, 20)
DECK = (4, 7, 9, 11)


def shaken_mps2(seed, duration_s=6.0):
    """Return a short motion between 1 and 8 Hz that starts and ends at rest."""
    rng = np.random.default_rng(seed)
    count = round(duration_s / DT_S)
    noise = in_band(rng.standard_normal(count), DT_S) * np.hanning(count)
    return noise / np.abs(noise).max()


def write_event(folder, channels=(*GROUND, *DECK), station=89324):
    """Write V2 files of one event; recorders number the channels from 15 on differently."""
    folder.mkdir(exist_ok=True)
    for channel in channels:
        values = 100.0 * shaken_mps2(channel)
        recorder = channel - 3 if channel > 14 else channel
        text = HEADER.format(
            station=station, recorder=recorder, channel=channel, direction="Tran",
            count=len(values), dt=DT_S,
        )  # fmt: skip
        (folder / f"CHAN{recorder:03d}.V2").write_text(text + rows_of(values, 8, "{:10.3f}") + "\n")
    return folder


def test_channels_are_those_of_the_station_and_one_may_be_replaced(tmp_path):
    station = read_station("painter")
    (event,) = read_events(write_event(tmp_path / "one"), station)
    assert (event.date, event.dt_s, event.notes) == ("2015-01-28", DT_S, ())
    assert set(event.accel_mps2) == {*GROUND, *DECK}
    assert event.accel_mps2[20] == pytest.approx(shaken_mps2(20), abs=1e-5)
    motions = event.motions(station)
    assert np.array_equal(motions["left"].accel_1_mps2, -event.accel_mps2[18])  # x is to the east
    assert np.array_equal(motions["bent 1"].accel_2_mps2, event.accel_mps2[3])
    without = {*GROUND, *DECK} - {15, 4}
    (event,) = read_events(write_event(tmp_path / "two", without), station)
    assert event.notes[0] == "channel 18 replaces channel 15"
    assert "channel 4 is missing: no deck west across" in event.notes
    assert len(read_events(tmp_path, station)) == 2


def test_other_stations_and_missing_channels_are_refused_in_one_sentence(tmp_path):
    other = write_event(tmp_path / "other", station=89005)
    code, answer = run("verify", "painter", "--records", other, "--out", tmp_path / "out")
    assert code == 2
    assert "station 89005 in its header, but Painter Street" in answer["message"]
    short = write_event(tmp_path / "short", (1, 3, 15, 18, 20))
    code, answer = run("verify", "painter", "--records", short, "--out", tmp_path / "out")
    assert code == 2
    assert "channel 7, 17 of station 89324 is missing" in answer["message"]
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match=r"no \.V2 file"):
        read_events(empty, read_station("painter"))


def test_without_records_the_study_is_skipped_with_its_reason(tmp_path):
    result = invoke("verify", "painter", "--out", tmp_path)
    assert result.exit_code == 0
    assert "--records DIR" in result.stderr


def test_a_band_keeps_its_middle_and_takes_derivatives_and_integrals():
    t_s = np.arange(0.0, 40.0, DT_S)
    speed, inside = 2 * np.pi * 2.0, slice(1000, 3000)
    wave = np.sin(speed * t_s) + 0.5 * np.sin(2 * np.pi * 0.1 * t_s)
    wave *= (1.0 - np.cos(np.pi * np.clip(np.minimum(t_s, t_s[-1] - t_s) / 5.0, 0.0, 1.0))) / 2.0
    assert in_band(wave, DT_S)[inside] == pytest.approx(np.sin(speed * t_s)[inside], abs=0.01)
    twice = in_band(wave, DT_S, 2)[inside] / speed**2
    assert twice == pytest.approx(-np.sin(speed * t_s)[inside], abs=0.01)
    back = in_band(wave, DT_S, -2)[inside] * speed**2
    assert back == pytest.approx(-np.sin(speed * t_s)[inside], abs=0.02)
    assert strong_part(np.hanning(2000) ** 4, DT_S).start > 300


@pytest.mark.parametrize(("period_s", "damping"), [(0.25, 0.05), (0.32, 0.2)])
def test_the_period_of_an_oscillator_between_two_grounds_is_identified(period_s, damping):
    grounds = np.column_stack([in_band(shaken_mps2(seed, 20.0), DT_S) for seed in (1, 2)])
    own, moved = 2 * np.pi / period_s, np.zeros(len(grounds))
    pushed, state = grounds @ [0.7, 0.5], np.zeros(2)
    fine = 20  # closed form replaced by small steps of the midpoint rule
    system = np.array([[0.0, 1.0], [-(own**2), -2 * damping * own]])
    half = DT_S / fine / 2
    step = np.linalg.solve(np.eye(2) - half * system, np.eye(2) + half * system)
    load = np.linalg.solve(np.eye(2) - half * system, [0.0, 2 * half])
    for row in range(1, len(moved)):
        for part in np.arange(0.5, fine) / fine:
            state = step @ state - load * ((1 - part) * pushed[row - 1] + part * pushed[row])
        moved[row] = system[1] @ state
    output = grounds @ [0.3, 0.5] + moved  # absolute acceleration
    found = identified_period(output, grounds, DT_S)
    assert found.period_s == pytest.approx(period_s, rel=0.01)
    assert found.damping == pytest.approx(damping, rel=0.05)
    assert found.explained > 0.999
    assert found.half_range_s < 0.01


def test_an_event_has_rows_with_null_uniform_correlation_and_error(tmp_path):
    study = run_study("painter", records=write_event(tmp_path / "event"))
    rows = {row["quantity"]: row for row in study.comparisons}
    drift = rows["2015-01-28 bent drift across (cm)"]
    assert {"null", "uniform", "correlation", "error"} <= drift.keys()
    recorded = in_band(shaken_mps2(7) - shaken_mps2(3), DT_S, -2) * 100.0
    assert drift["reference"] == pytest.approx(np.abs(recorded).max(), rel=0.02)
    assert not drift["pass"]  # the motions of the channels are independent noise
    assert "2015-01-28 period across (s)" in rows
    changes = study.tables["changes"]
    assert set(changes["model"]) >= {"model", "null", "uniform input", "no skew", "rigid deck",
                                     "fixed bases", "equal ends", "square bents"}  # fmt: skip
    assert set(study.figures) == {"2015-01-28", "changes"}


def test_the_page_states_the_numbers_of_its_stored_tables():
    page = " ".join((ROOT / "docs/theory/recorded.md").read_text().split())
    readme = " ".join((ROOT / "README.md").read_text().split())
    rows = pd.read_csv(ROOT / "docs/data/recorded.csv").set_index(["event", "quantity"])
    drift = rows.loc["1992 predicted", "bent drift across (cm)"]
    ratio, correlation = drift["predicted / recorded"], drift["correlation"]
    assert f"is {ratio} times the recorded one with a correlation of {correlation}:" in page
    assert f"The null has {drift['null']} and {drift['its correlation']}:" in page
    assert f"it gives {ratio} times the recorded peak" in readme
    assert (drift["result"] == "miss") == (not 0.75 <= ratio <= 1.3 or correlation < 0.85)
    fits = pd.read_csv(ROOT / "docs/data/recorded_fit.csv")
    crossed = fits[(fits["quantity"] == "bent drift across") & (fits["fitted_to"] != fits["event"])]
    sentences = {
        "2015-01-28": "a ratio of {}, a correlation of {} and an error of {};",
        "2019-06-22": "that of 2015 has {}, {} and {} (",
    }
    for row in crossed.itertuples():
        if row.fitted_to == "both":
            continue
        values = (f"{value:.2f}" for value in (row.peak_ratio, row.correlation, row.error))
        assert sentences[row.fitted_to].format(*values) in page
        assert abs(row.peak_ratio - 1.0) <= 0.031  # of the README


def test_the_numbers_of_the_bridge_are_those_of_the_fit_and_at_most_six():
    bridge = load_bridge("painter")
    fits = pd.read_csv(ROOT / "docs/data/recorded_fit.csv")
    both = fits[fits["fitted_to"] == "both"].iloc[0]
    ends = bridge.ends
    assert bridge.deck.elastic_modulus_gpa == pytest.approx(both["deck_modulus_gpa"], rel=0.05)
    for side, end in (("west", ends["left"]), ("east", ends["right"])):
        assert end.piles.lateral_kn_per_m == pytest.approx(both[f"piles_{side}_kn_per_m"], rel=0.05)
        assert end.piles.dashpot_s == pytest.approx(both["piles_dashpot_s"], rel=0.05)
        assert end.backfill.stiffness_mn_per_m == pytest.approx(both["fill_mn_per_m2"], rel=0.05)
    assert bridge.foundation.krx_mnm_per_rad == pytest.approx(both["rocking_mnm_per_rad"], rel=0.05)
    fitted = [name for name, source in bridge.sources.items() if "fitted: 2015, 2019" in source]
    single = [name for name in fitted if "one number with" not in bridge.sources[name]]
    assert len(single) == 6
