"""An instrumented bridge: its station, identified periods, stored results, support motions."""

import numpy as np
import pandas as pd
import pytest
from reference_pages import ROOT
from scipy import signal

from bridge_variants import analysed, variant
from cli_json import answer, invoke
from motions_files import at2_text, rows_of
from skewbridge.analysis.ground import displacements_m, support_lines, support_of
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.errors import InputError
from skewbridge.motions.read import read_support_motions
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import run_study
from skewbridge.verification.studies import recorded as recordings
from strong_motion import strong_motion

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
SUPPORTS = ("left", "bent 1", "right")
OPTIONS = ModelOptions(rayleigh="stiffness")
DEMANDS = ("column_drift_ratio", "column_shear_kn", "deck_disp_m", "deck_accel_mps2")


def shaken_mps2(seed, duration_s=6.0):
    """Return a short motion between 1 and 8 Hz that starts and ends at rest."""
    rng = np.random.default_rng(seed)
    count = round(duration_s / DT_S)
    noise = recordings.in_band(rng.standard_normal(count), DT_S) * np.hanning(count)
    return noise / np.abs(noise).max()


def write_event(folder, channels=(*GROUND, *DECK), station=89324):
    """Write V2 files of one event; recorders number the channels from 15 on differently."""
    folder.mkdir(exist_ok=True)
    for channel in channels:
        values = 100.0 * shaken_mps2(channel)
        recorder = channel - 3 if channel > 14 else channel
        facts = {"station": station, "recorder": recorder, "channel": channel, "dt": DT_S}
        text = HEADER.format(**facts, direction="Tran", count=len(values))
        (folder / f"CHAN{recorder:03d}.V2").write_text(text + rows_of(values, 8, "{:10.3f}") + "\n")
    return folder


def test_channels_are_those_of_the_station_and_one_may_be_replaced(tmp_path):
    station = recordings.read_station("painter")
    (event,) = recordings.read_events(write_event(tmp_path / "one"), station)
    assert (event.date, event.dt_s, event.notes) == ("2015-01-28", DT_S, ())
    assert set(event.accel_mps2) == {*GROUND, *DECK}
    assert event.accel_mps2[20] == pytest.approx(shaken_mps2(20), abs=1e-5)
    motions = event.motions(station)
    assert np.array_equal(motions["left"].accel_1_mps2, -event.accel_mps2[18])  # x is to the east
    assert np.array_equal(motions["bent 1"].accel_2_mps2, event.accel_mps2[3])
    without = {*GROUND, *DECK} - {15, 4}
    (event,) = recordings.read_events(write_event(tmp_path / "two", without), station)
    assert event.notes[0] == "channel 18 replaces channel 15"
    assert "channel 4 is missing: no deck west across" in event.notes
    assert len(recordings.read_events(tmp_path, station)) == 2


def test_other_stations_and_missing_channels_are_refused_and_without_records_nothing_runs(tmp_path):
    other = write_event(tmp_path / "other", station=89005)
    short = write_event(tmp_path / "short", (1, 3, 15, 18, 20))
    for records, words in (
        (other, "station 89005 in its header, but Painter Street"),
        (short, "channel 7, 17 of station 89324 is missing"),
    ):
        given = ("verify", "painter", "--records", records, "--out", tmp_path / "out")
        assert words in answer(*given, code=2)["message"]
    (empty := tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"no \.V2 file"):
        recordings.read_events(empty, recordings.read_station("painter"))
    result = invoke("verify", "painter", "--out", tmp_path)
    assert result.exit_code == 0
    assert "--records DIR" in result.stderr


def test_a_band_keeps_its_middle_and_takes_derivatives_and_integrals():
    t_s = np.arange(0.0, 40.0, DT_S)
    speed, inside = 2 * np.pi * 2.0, slice(1000, 3000)
    wave = np.sin(speed * t_s) + 0.5 * np.sin(2 * np.pi * 0.1 * t_s)
    wave *= (1.0 - np.cos(np.pi * np.clip(np.minimum(t_s, t_s[-1] - t_s) / 5.0, 0.0, 1.0))) / 2.0
    sine = np.sin(speed * t_s)[inside]
    for order, sign, error in ((0, 1.0, 0.01), (2, -1.0, 0.01), (-2, -1.0, 0.02)):
        found = recordings.in_band(wave, DT_S, order)[inside] / speed**order
        assert found == pytest.approx(sign * sine, abs=error)
    assert recordings.strong_part(np.hanning(2000) ** 4, DT_S).start > 300


@pytest.mark.parametrize(("period_s", "damping"), [(0.25, 0.05), (0.32, 0.2)])
def test_the_period_of_an_oscillator_between_two_grounds_is_identified(period_s, damping):
    pair = [recordings.in_band(shaken_mps2(seed, 20.0), DT_S) for seed in (1, 2)]
    grounds = np.column_stack(pair)
    omega, pushed = 2 * np.pi / period_s, grounds @ [0.7, 0.5]
    system = [[0.0, 1.0], [-(omega**2), -2 * damping * omega]]
    oscillator = signal.StateSpace(system, [[0.0], [-1.0]], [system[1]], [[0.0]])
    _, moved, _ = signal.lsim(oscillator, pushed, DT_S * np.arange(len(pushed)))
    output = grounds @ [0.3, 0.5] + moved  # absolute acceleration
    found = recordings.identified_period(output, grounds, DT_S)
    assert found.period_s == pytest.approx(period_s, rel=0.01)
    assert found.damping == pytest.approx(damping, rel=0.05)
    assert found.explained > 0.999
    assert found.half_range_s < 0.01


def test_an_event_has_rows_with_null_uniform_correlation_and_error(tmp_path):
    study = run_study("painter", records=write_event(tmp_path / "event"))
    rows = {row["quantity"]: row for row in study.comparisons}
    drift = rows["2015-01-28 bent drift across (cm)"]
    assert {"null", "uniform", "correlation", "error"} <= drift.keys()
    recorded = recordings.in_band(shaken_mps2(7) - shaken_mps2(3), DT_S, -2) * 100.0
    assert drift["reference"] == pytest.approx(np.abs(recorded).max(), rel=0.02)
    # the motions of the channels are independent noise
    assert (drift["pass"], "correlation " in drift["missed"]) == (False, True)
    assert "2015-01-28 period across (s)" in rows
    changes = study.tables["changes"]
    names = {"uniform input", "no skew", "rigid deck", "fixed bases", "equal ends", "square bents"}
    assert set(changes["model"]) >= {"model", "null", *names}
    assert set(study.figures) == {"2015-01-28", "changes"}


def test_the_readme_and_the_bridge_have_the_numbers_of_the_stored_tables():
    rows = pd.read_csv(ROOT / "docs/data/recorded.csv").set_index(["event", "quantity"])
    drift = rows.loc["1992 predicted", "bent drift across (cm)"]
    ratio, correlation = drift["predicted / recorded"], drift["correlation"]
    readme = (ROOT / "README.md").read_text()
    assert f"it gives {ratio} times the recorded peak" in " ".join(readme.split())
    assert (drift["result"] == "miss") == (not 0.75 <= ratio <= 1.3 or correlation < 0.85)
    fits = pd.read_csv(ROOT / "docs/data/recorded_fit.csv")
    single = fits.query("quantity == 'bent drift across' and event != fitted_to != 'both'")
    assert (single["peak_ratio"] - 1.0).abs().max() <= 0.031  # of the README
    bridge = load_bridge("painter")
    both = fits[fits["fitted_to"] == "both"].iloc[0]
    pairs = [(bridge.deck.elastic_modulus_gpa, both["deck_modulus_gpa"]),
             (bridge.foundation.krx_mnm_per_rad, both["rocking_mnm_per_rad"])]  # fmt: skip
    for side, end in (("west", bridge.ends["left"]), ("east", bridge.ends["right"])):
        pairs += [(end.piles.lateral_kn_per_m, both[f"piles_{side}_kn_per_m"]),
                  (end.piles.dashpot_s, both["piles_dashpot_s"]),
                  (end.backfill.stiffness_mn_per_m, both["fill_mn_per_m2"])]  # fmt: skip
    np.testing.assert_allclose(*np.transpose(pairs), rtol=0.05)
    fitted = [name for name, source in bridge.sources.items() if "fitted: 2015, 2019" in source]
    assert len([name for name in fitted if "one number with" not in bridge.sources[name]]) == 6
    station = recordings.read_station("painter")
    cases = [station.changed(station.changes[name]) for name in ("rigid deck", "equal ends")]
    stiff, equal = (load_bridge(case.variant.bridge) for case in cases)
    assert stiff.deck.inertia_transverse_m4 == 100.0 * bridge.deck.inertia_transverse_m4
    piles = [b.ends[end].piles.lateral_kn_per_m for b in (equal, bridge) for end in b.ends]
    assert piles[:2] == pytest.approx([(piles[2] * piles[3]) ** 0.5] * 2, rel=1e-12)


@pytest.mark.parametrize(
    ("case", "demands"),
    [
        (variant(30, gap_mm=25), (*DEMANDS, "unseating_m", "backwall_force_kn")),
        (variant(-39, bridge="painter"), DEMANDS),
    ],
)
def test_one_motion_at_all_supports_has_the_peaks_of_uniform_input(case, demands):
    motion = strong_motion()
    uniform = analysed(case, motion, OPTIONS, dt_s=0.005)
    # whatever the option says, damping is proportional to stiffness under support motions
    apart = analysed(case, motion, supports=dict.fromkeys(SUPPORTS, motion), dt_s=0.005)
    for name in demands:
        assert apart.demands[name] == pytest.approx(uniform.demands[name], rel=0.01), name
    assert np.isnan(apart.demands["energy_residual_ratio"])
    assert "residual drift at the last step" in apart.messages[0]


def test_supports_keep_their_velocity_after_a_cut_and_short_records_end_with_zeros():
    motion, cut = strong_motion(peak_g=0.1, duration_s=3.0), {"duration_s": 1.6}
    same = dict.fromkeys(SUPPORTS, motion)
    short = motion.mapped(lambda accel: accel[:150])
    padded = short.mapped(lambda accel: np.pad(accel, (0, 151)))
    for given in (
        [(motion, supports, cut | {"free_vibration_s": 2.0}) for supports in ({}, same)],
        [(middle, same | {"bent 1": middle}, {}) for middle in (short, padded)],
    ):
        one, other = (
            analysed(variant(30), motion, OPTIONS, supports=supports, **settings).demands
            for motion, supports, settings in given
        )
        for name in ("column_drift_ratio", "deck_disp_m"):
            assert other[name] == pytest.approx(one[name], rel=0.02), name


def test_supports_share_a_slow_motion_of_one_end_and_do_not_drift_apart():
    """At 0.4 Hz one end moves 0.2 mm along: all springs are elastic and inertia is small."""
    t_s = np.arange(0.0, 12.0, 0.01)
    ground_m = 2e-4 * np.sin(2 * np.pi * 0.4 * t_s) * np.hanning(len(t_s))
    accel = np.gradient(np.gradient(ground_m, 0.01), 0.01)
    still = GroundMotion(motion_id="still", dt_s=0.01, accel_1_mps2=0 * t_s, accel_2_mps2=0 * t_s)
    along = still.with_components(accel, 0 * t_s)
    case = variant(0, bridge="painter")
    supports = {"left": still, "bent 1": still, "right": along}
    found = analysed(case, still, OPTIONS, supports=supports, dt_s=0.005).histories
    pushed, middle, held = (
        np.interp(t_s, found["t_s"], found[name])
        for name in ("abutment_right_x_m", "deck_ux_m", "abutment_left_x_m")
    )
    peak = int(np.abs(ground_m).argmax())
    moved = pushed[peak] + ground_m[peak]  # histories are relative to the ground of the support
    shares = [place / ground_m[peak] for place in (held[peak], middle[peak], moved)]
    # the piles of this end have 0.65 of the stiffness of all piles; the deck shortens
    assert 0.2 < shares[0] < shares[1] < shares[2] < 0.8
    drift = np.interp(t_s, found["t_s"], found["column_1_drift_ratio"])[peak]
    # of columns whose base moves on its springs, without the motion of the ground elsewhere
    assert 0.5 < drift / (abs(middle[peak]) / 7.3) < 1.0
    t_s, speed = np.arange(0.0, 40.0, 0.005), 2 * np.pi / 0.8
    wave_m = 0.05 * np.sin(speed * t_s + 0.7)  # starts with 0.3 m/s, which no record states
    accel = (-(speed**2) * wave_m)[:, None]
    found = displacements_m({"left": accel, "right": -accel}, 0.005)
    apart = (found["left"] - found["right"])[:, 0]
    assert apart[0] == 0.0
    assert abs(apart[1]) < 1e-4
    assert np.abs(apart - 2 * wave_m)[t_s > 8.0].max() < 0.05 * 0.05
    same = displacements_m({"left": accel, "right": accel}, 0.005)["left"][:, 0]
    drifting = wave_m - wave_m[0] - 0.05 * speed * np.cos(0.7) * t_s
    assert same == pytest.approx(drifting, rel=1e-3, abs=2e-3)


def test_a_node_belongs_to_the_support_whose_own_skewed_line_is_nearest(written):
    ends = "abutments: {left: {skew_deg: 60.0}}\nspans_m: [20.0, 50.0]\n"
    name = written(f"extends: painter\ntitle: own skew\nsource: 'd: test'\n{ends}")
    with domain():
        model = build(variant(-39, bridge=name), OPTIONS)
        lines = support_lines(model)
        assert tuple(lines) == SUPPORTS
        for end in model.abutments:
            nodes = {*end.holders, *(spring.nodes[0] for spring in end.wall_springs)}
            # the wall of the left end reaches to x = -22.5, closer to the bent than to its middle
            assert {support_of(node, lines) for node in nodes} == {end.side}
        assert {support_of(column.base_node, lines) for column in model.columns} == {"bent 1"}
    with domain():
        lines = support_lines(build(variant(30, bridge=str(ROOT / "docs/own_bridge.py")), OPTIONS))
    assert (tuple(lines), lines["bent 1"][1]) == (SUPPORTS, pytest.approx(0.0))


def test_support_motions_of_a_file(tmp_path):
    motion = strong_motion(duration_s=3.0)
    for name, accel, start_s in zip("xy", motion.components, (0, 2), strict=True):
        (tmp_path / f"{name}.AT2").write_text(at2_text(accel / G_MPS2, motion.dt_s))
        rows = [f"{start_s + 0.01 * i:.2f},{i % 7 - 3}" for i in range(60)]
        (tmp_path / f"{start_s}.csv").write_text("\n".join(["s,m/s2", *rows]))
    lines = [f"- {{support: {support}, direction: {axis}, record: {axis}.AT2, factor: {factor}}}"
             for support, factor in zip(SUPPORTS, (1, 1, -1), strict=True)
             for axis in "xy"]  # fmt: skip
    path = tmp_path / "supports.yaml"
    path.write_text(text := "\n".join(lines))
    read = read_support_motions(path)
    assert tuple(read) == SUPPORTS
    for one, other in zip(read["left"].components, read["right"].components, strict=True):
        assert np.array_equal(one, -other)
    options = ("--support-motions", path, "--out", tmp_path / "out")
    assert answer("run", *options)["status"] == "ok"
    answer("run", *options, "--motion", "a", "b", code=2)
    early = text.replace("x.AT2, factor: 1", "0.csv")
    for changed, message in (
        ("\n".join(lines[1:]), "left needs a record along x and one along y"),
        ("\n".join([*lines, lines[0]]), "left has two records along x"),
        (early.replace("x.AT2", "2.csv"), "begin at 0 s in 0.csv and 2 s in 2.csv"),
    ):
        path.write_text(changed)
        with pytest.raises(InputError, match=message):
            read_support_motions(path)
    path.write_text(early.replace("y.AT2, factor: 1", "0.csv"))
    last = {name: motion.messages[-1] for name, motion in read_support_motions(path).items()}
    assert [n for n in last if "at 0.59 s, others at 3 s" in last[n]] == ["left", "bent 1"]
    path.write_text("\n".join(lines[:4]))
    assert "for the supports left, bent 1, right" in answer("run", *options, code=2)["message"]
