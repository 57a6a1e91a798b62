"""Motions of single supports: equal ones are uniform input, others move the supports apart."""

import numpy as np
import pytest

from bridge_variants import variant
from cli_json import run
from motions_files import at2_text
from skewbridge.analysis.ground import Excitation, displacements_m
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.errors import InputError
from skewbridge.motions.read import read_support_motions
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion

SUPPORTS = ("left", "bent 1", "right")
OPTIONS = ModelOptions(rayleigh="stiffness")
DEMANDS = ("column_drift_ratio", "column_shear_kn", "deck_disp_m", "deck_accel_mps2")


def analysed(case, motion, supports=None, options=OPTIONS):
    settings = AnalysisSettings(dt_s=0.005)
    excitation = Excitation(motion=motion, supports=supports or {})
    return analyse(case, excitation, settings, options, histories=True)


@pytest.mark.parametrize(
    ("case", "demands"),
    [
        (variant(30, gap_mm=25), (*DEMANDS, "unseating_m", "backwall_force_kn")),
        (variant(-39, bridge="painter"), DEMANDS),
    ],
)
def test_one_motion_at_all_supports_has_the_peaks_of_uniform_input(case, demands):
    motion = strong_motion()
    uniform = analysed(case, motion)
    # whatever the option says, damping is proportional to stiffness under support motions
    apart = analysed(case, motion, dict.fromkeys(SUPPORTS, motion), ModelOptions())
    for name in demands:
        assert apart.demands[name] == pytest.approx(uniform.demands[name], rel=0.01), name
    assert np.isnan(apart.demands["energy_residual_ratio"])
    assert "residual drift at the last step" in apart.messages[0]


def test_a_slow_motion_of_one_end_is_shared_by_the_supports():
    """At 0.4 Hz one end moves 0.2 mm along: all springs are elastic and inertia is small."""
    t_s = np.arange(0.0, 12.0, 0.01)
    ground_m = 2e-4 * np.sin(2 * np.pi * 0.4 * t_s) * np.hanning(len(t_s))
    accel = np.gradient(np.gradient(ground_m, 0.01), 0.01)
    still = GroundMotion(motion_id="still", dt_s=0.01, accel_1_mps2=0 * t_s, accel_2_mps2=0 * t_s)
    along = still.with_components(accel, 0 * t_s)
    case = variant(0, bridge="painter")
    found = analysed(case, still, {"left": still, "bent 1": still, "right": along}).histories
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


def test_supports_neither_drift_apart_nor_start_with_a_velocity():
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


def test_support_motions_of_a_file(tmp_path):
    motion = strong_motion(duration_s=3.0)
    for name, accel in zip("xy", motion.components, strict=True):
        (tmp_path / f"{name}.AT2").write_text(at2_text(accel / G_MPS2, motion.dt_s))
    lines = [
        f"- {{support: {support}, direction: {axis}, record: {axis}.AT2, factor: {factor}}}"
        for support, factor in zip(SUPPORTS, (1, 1, -1), strict=True)
        for axis in "xy"
    ]
    path = tmp_path / "supports.yaml"
    path.write_text("\n".join(lines))
    read = read_support_motions(path)
    assert tuple(read) == SUPPORTS
    for one, other in zip(read["left"].components, read["right"].components, strict=True):
        assert np.array_equal(one, -other)
    options = ("--support-motions", path, "--out", tmp_path / "out", "--no-figures")
    code, row = run("run", *options)
    assert (code, row["status"]) == (0, "ok")
    assert run("run", *options, "--motion", "a", "b")[0] == 2

    path.write_text("\n".join(lines[1:]))
    with pytest.raises(InputError, match="left needs a record along x and one along y"):
        read_support_motions(path)
    path.write_text("\n".join([*lines, lines[0]]))
    with pytest.raises(InputError, match="left has two records along x"):
        read_support_motions(path)
    path.write_text("\n".join(lines[:4]))
    code, answer = run("run", *options)
    assert code == 2
    assert "the supports are left, bent 1, right" in answer["message"]
