"""Own OpenSeesPy scripts as bridges: the same demands as the catalogue, units, errors, digests."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skewbridge.analysis import bridge_check, ground, settings
from skewbridge.analysis.model_script import model_script, recording
from skewbridge.analysis.transient import analyse
from skewbridge.bridge import catalogue, handles, structures
from skewbridge.bridge.backfill import wing_wall
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, domain
from skewbridge.cli.output import VariantOptions
from skewbridge.demands.columns import demands_for
from skewbridge.errors import InputError
from skewbridge.files.text import merged
from skewbridge.motions.record import GroundMotion
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import check_inputs
from skewbridge.units import G_MPS2, INCH, KIP
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS, ModelOptions
from skewbridge.variant.variant import Variant

ROOT = Path(__file__).parents[2]
USUAL = {"skew_deg": 0.0, "gap_mm": 25.0, "friction": 0.5}
SCRIPTS = [*sorted((ROOT / "docs").glob("bridges/*.py")), ROOT / "docs/own_bridge.py"]


def osb1_as_script(path: Path, skew_deg: float) -> str:
    structure = structures.CatalogueBridge(catalogue.load_bridge("osb1"))
    with recording() as record, domain():
        frame = structure.build(skew_deg, ModelOptions(), handles.TagAllocator())
        lines = [line for line in record if not re.match(r"ops\.(wipe|model)\(", line)]
        lines += ["ops.timeSeries('Linear', 1)", "ops.pattern('Plain', 1, 1)"]
        for node, load in frame.loads.forces_n.items():
            moments = frame.loads.moments_nm.get(node, (0.0, 0.0))
            lines.append(f"ops.load({node}, 0.0, 0.0, {-load!r}, *{moments!r}, 0.0)")
    column, model = frame.columns[0], "\n    ".join(lines)
    capacity = column.capacities[0]
    columns = [(each.element, each.base_node, each.top.node) for each in frame.columns]
    path.write_text(
        f"""import openseespy.opensees as ops
import skewbridge as sb
from skewbridge.bridge.section import ShearSection, shear_strength

SECTION = {capacity.shear!r}


def strength(axial, drift, curvature):
    return shear_strength(SECTION, "ucsd_tests", axial, drift, curvature)


def bridge(skew_deg):
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    {model}
    return sb.Frame(
        ends=(1, 9), width=14.33, soffit=1.010, centre=5, damping_periods=(0.94, 0.35), t1=0.7192,
        damped={list(frame.damping.elements)},
        columns=[
            sb.Column(element, base, top, height=5.64,
                      drift_capacity={capacity.drift_capacity_ratio!r},
                      yield_drift={capacity.yield_drift_ratio!r},
                      yield_curvature={capacity.yield_curvature_per_m!r},
                      hinges={column.hinge_sections}, shear_strength=strength)
            for element, base, top in {columns}
        ],
    )
"""
    )
    return str(path)


def run(bridge: str, abutment: str, skew_deg: float, gap_mm: float, peak_mps2=6.0, **options):
    time = np.arange(0.0, 3.0, 0.02)
    pulse = peak_mps2 * np.sin(2 * np.pi * time / 0.8) * np.exp(-((time - 1.2) ** 2))
    components = {"accel_1_mps2": pulse, "accel_2_mps2": 0.6 * np.roll(pulse, 9)}
    motion = GroundMotion(motion_id="pulse", dt_s=0.02, **components)
    values = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": 0.5}
    variant = Variant.at(bridge, abutment, values).normalised()
    arguments = ground.Excitation(motion=motion), settings.AnalysisSettings()
    return analyse(variant, *arguments, ModelOptions(**options), histories=True)


@pytest.mark.parametrize("case", [("contact_friction", 30, 25, 6.0), ("spring", -45, 51, 9.0)])
def test_osb1_as_a_script_has_the_demands_of_the_catalogue(tmp_path, case):
    script = osb1_as_script(tmp_path / "mine.py", skew_deg=case[1])
    own, usual = (run(bridge, *case) for bridge in (script, "osb1"))
    assert own.status == usual.status
    others = set(SHEAR_MODEL_DEMANDS.values()) - {SHEAR_MODEL_DEMANDS["ucsd_tests"]}  # not stated
    expected = {name: usual.demands[name] for name in usual.demands.keys() - others}
    found = {name: own.demands[name] for name in expected}
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_histories_leave_out_a_column_without_capacities(tmp_path):
    script = Path(osb1_as_script(tmp_path / "mine.py", 0.0))
    text = script.read_text().replace("=strength)", "=strengths.pop())")
    script.write_text(text.replace("(skew_deg):", "(skew_deg):\n    strengths = [None, strength]"))
    found, name = run(str(script), "roller", 0, 25), "column_shear_dcr"
    assert found.demands[name] == pytest.approx(found.histories[name].max(), rel=0.01)


def two_spans(length: float, force: float, units: str) -> str:
    return f"""
import openseespy.opensees as ops
import skewbridge as sb

M, N = {1 / length!r}, {1 / force!r}
PA, KG = N / M**2, N / M

def bridge():
    for tag, x in enumerate((-40.0, -20.0, 0.0, 20.0, 40.0), start=1):
        ops.node(tag, x * M, 0.0, 7.2 * M)
        share = 1.0 if abs(x) < 40.0 else 0.5
        m, r = share * 4.0e5 * KG, share * 6.0e6 * N * M
        ops.mass(tag, m, m, m, r, 1.0e5 * N * M, r)
    ops.node(10, 0.0, 0.0, 6.2 * M)
    ops.node(11, 0.0, 0.0, 0.0)
    ops.fix(11, 1, 1, 1, 1, 1, 1)
    ops.rigidLink("beam", 3, 10)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    ops.geomTransf("PDelta", 2, 1.0, 0.0, 0.0)
    for tag in range(1, 5):
        ops.element("elasticBeamColumn", tag, tag, tag + 1, 7.0 * M**2, 2.5e10 * PA, 1.0e10 * PA,
                    10.0 * M**4, 3.5 * M**4, 110.0 * M**4, 1)
    ops.uniaxialMaterial("Steel01", 1, 4.0e7 * N * M, 2.4e10 * N * M**2, 0.01)
    ops.uniaxialMaterial("Elastic", 3, 7.5e10 * N)
    ops.uniaxialMaterial("Elastic", 4, 8.0e9 * N * M**2)
    ops.section("Aggregator", 1, 3, "P", 1, "Mz", 1, "My", 4, "T")
    ops.beamIntegration("Lobatto", 1, 1, 5)
    ops.element("forceBeamColumn", 20, 11, 10, 2, 1)
    return sb.Frame(
        ends=(1, 5), width=13.0 * M, soffit=1.1 * M, units="{units}", damped=[1, 2, 3, 4, 20],
        columns=[sb.Column(20, 11, 10, drift_capacity=(0.05, 0.04), shear_strength=5.0e6 * N,
                           yield_curvature=0.0017 / M, hinges=(1, 5))],
    )
"""


@pytest.mark.parametrize("pads", ["two", "each"])
def test_the_units_of_a_script_do_not_change_its_demands(tmp_path, pads):
    paths = [tmp_path / "si.py", tmp_path / "us.py"]
    paths[0].write_text(two_spans(1.0, 1.0, "N-m"))
    paths[1].write_text(two_spans(INCH, KIP, "kip-in"))
    si, us = map(load_structure, paths)
    case = ("contact_friction", 30.0, 25.0, 8.0)
    in_si, in_us = (run(str(path), *case, pads=pads) for path in paths)
    lengths_m = {"spans_m": (40.0, 40.0), "bent_heights_m": (6.2,), "width_m": 13.0}
    lengths_m = {name: pytest.approx(value) for name, value in lengths_m.items()}
    assert us.description == replace(si.description, title="us", **lengths_m)
    assert us.t1_s == pytest.approx(si.t1_s, rel=1e-9)
    values = USUAL | {"skew_deg": 30}
    text = model_script(Variant.at(str(paths[1]), "contact", values), ModelOptions())
    assert "force is\n4448.221615 N, that of length 0.0254 m" in text
    assert min(in_si.demands[name] for name in ("contact_closures", "slip_work_kj")) > 0.0
    # rounding decides sub-steps of sliding, and with them the path to rest: no effect of its drift
    names = demands_for("effect")
    si, us = ({name: each.demands[name] for name in names} for each in (in_si, in_us))
    assert us == pytest.approx(si, rel=1e-6, abs=1e-9)
    share = 1e-3 * in_si.energy_kj["largest_input"]
    for part in ("input", "gravity", "columns", "deck", "damping", "links"):
        assert in_us.energy_kj[part] == pytest.approx(in_si.energy_kj[part], abs=share)
    assert abs(in_us.demands["energy_residual_ratio"]) < 0.02


GOOD = two_spans(1.0, 1.0, "N-m")
HEAD, FIX, PDELTA = "def bridge():", "ops.fix(11, 1, 1, 1, 1, 1, 1)", '"PDelta", 2, 1.0, 0.0, 0.0'
PATTERN = FIX + '; ops.timeSeries("Linear", 1); ops.pattern("Plain", 1, 1)'
#: A column on foundation springs that the frame does not have.
SECOND = """
    ops.node(12, 20.0, 0.0, 0.0); ops.node(13, 20.0, 0.0, 0.0); ops.fix(13, *[1] * 6)
    ops.uniaxialMaterial("Elastic", 9, 1e9)
    ops.element("zeroLength", 30, 13, 12, "-mat", *[9] * 6, "-dir", 1, 2, 3, 4, 5, 6)
    ops.geomTransf("PDelta", 9, 1.0, 0.0, 0.0)
    ops.element("elasticBeamColumn", 21, 12, 4, 2.5, 28e9, 12e9, 0.2, 0.2, 0.2, 9)"""
#: A support of a deck end from the abutment model of the script.
SPRING = """
    ops.node(14, 40.0, 0.0, 7.2); ops.fix(14, *[1] * 6); ops.uniaxialMaterial("Elastic", 9, 1e9)
    ops.element("zeroLength", 31, 14, 5, "-mat", 9, "-dir", 1)"""
IN_PLANE = """
    ops.wipe(); ops.model("basic", "-ndm", 2, "-ndf", 3); ops.geomTransf("Linear", 1)
    ops.node(1, M, M); ops.node(2, M, 0.0); ops.element("elasticBeamColumn", 1, 1, 2, M, M, M, 1)"""


def frame_of(written, text: str = GOOD):
    structure = load_structure(written(text, "mine.py"))
    return structure.build(0.0, ModelOptions(), handles.TagAllocator())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (HEAD, "def model():", r"mine\.py: .* must have a function bridge\(\)"),
        (HEAD, "def bridge(depth):", r"mine\.py:\d+: parameter depth .*must be skew_deg"),
        ("return sb.Frame(", "dict(", r"bridge\(\) must return a skewbridge.Frame, got None"),
        ("ends=(1, 5)", "ends=(1, 11)", r"ends: node 11 must not be fixed"),
        (FIX, FIX + SPRING, r"ends: element 31 supports node 5 .* nodes \[14\]: delete"),
        ("Column(20, 11, 10", "Column(20, 10, 11", r"element 20 must start at the base, node 10"),
        # OpenSees ends the process for a vector along the element, also of an inclined one
        (PDELTA, '"PDelta", 2, 0.0, 0.0, 1.0',
         r"mine\.py:\d+: geomTransf 2: its vector .* 0.1 degrees off .* element 20, got 0"),
        ('"Linear", 1, 0.0, 0.0, 1.0', '"Linear", 1, -2.0, 0.0, 0.0', "axis .* element 1, got 0"),
        (PDELTA, '"PDelta", 2, 1.0, 0.0, 1.0, "-jntOffset", *[0.0] * 3, 6.2, 0.0, 0.0',
         r"off the axis \[6.2, 0.0, 6.2\] of element 20"),
        ("soffit=1.1 * M", "soffit=0.0", "soffit must be at least 0.01, got 0"),
        ('units="N-m"', 'units="kip"', "units must be FORCE-LENGTH .* got 'kip'"),
        ("damped=[1, 2", "damped=[1, 7", "damped: the model has no element 7"),
        ("ops.mass(", "(lambda *_: 0)(", "no nodal masses"),
        (FIX, "M.x", r"mine\.py:\d+: AttributeError: 'float'"),
        (FIX, "ops.node(1, 0.0)", r"mine\.py:\d+: OpenSees refuses .*0\): insufficient number of"),
        (FIX, "ops.node(12, M, M, M)", r"mine\.py: node 12 has neither elements nor constraints"),
        ("110.0 * M**4, 1)", '110.0 * M**4, 1, "-mass", 9.0)',
         r"mine\.py:\d+: element 1: give its mass to nodes"),
        (FIX, 'ops.timeSeries("Linear", 1, "-factor", 2.0)', r"mine\.py:\d+: omit -factor"),
        (FIX, "exit(3)", r"mine\.py:\d+: SystemExit: 3"),
        ("hinges=(1, 5)", "hinges=(1, 9)", "has no integration point 9"),
        ("drift_capacity=(0.05,", "drift_capacity=(4.5,", "at most 1, got 4.5"),
        (HEAD, "def bridge()", r"mine\.py:\d+: expected ':'"),
        (FIX, FIX + SECOND, "columns: element 21 stands on a support below the deck"),
        ("x * M, 0.0,", "0.98 * x, 0.2 * x,", "the deck must be within 10 degrees of x"),
        ("=5.0e6 * N", "='5 MN'", r"columns\.0\.shear_strength must be positive, got 5 MN"),
        (HEAD, HEAD + IN_PLANE, "3 dimensions and 6 degrees of freedom, got 2 and 3"),
    ],
)  # fmt: skip
def test_errors_of_a_script_name_file_and_line_or_field(written, old, new, words):
    assert old in GOOD
    with pytest.raises(InputError, match=words):
        frame_of(written, GOOD.replace(old, new))


def test_prints_and_folders_of_a_script_disturb_no_command(tmp_path, written, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    frame_of(written, GOOD.replace(HEAD, f"{HEAD}\n    import os; os.chdir('/'); print('hello')"))
    assert Path.cwd() == tmp_path
    assert ["hello" in printed for printed in capsys.readouterr()] == [False, True]


def test_a_deck_node_without_mass_keeps_the_energy_balance(written):
    node = "ops.node(6, -30.0, 0.0, 7.2)\n    for tag in range(2, 5):"
    halves = """for tag, i, j in ((1, 1, 6), (6, 6, 2)):
        ops.element("elasticBeamColumn", tag, i, j, 7.0, 25e9, 1e10, 10.0, 3.5, 99.0, 1)
    ops.uniaxialMaterial("""
    text = GOOD.replace("for tag in range(1, 5):", node).replace("damped=[", "damped=[6, ")
    text = text.replace("ops.uniaxialMaterial(", halves, 1)
    found = run(written(text, "mine.py"), "contact_friction", 30.0, 25.0)
    assert abs(found.demands["energy_residual_ratio"]) < 0.01


def test_a_deck_lumped_at_one_node_has_modes_and_an_empty_pattern_is_no_dead_load(written):
    pattern = PATTERN + "; ops.mass(11, 1e5, 1e5, 1e5, 0.0, 0.0, 0.0)"  # does not move
    periods_s = []
    for rest in (0.0, 1e-6):  # ARPACK finds no modes of three masses
        text = GOOD.replace("share * 6.0e6", "0").replace("1.0e5 * N * M, r", "0, 0")
        text = text.replace("1.0 if abs(x) < 40.0 else 0.5", f"{rest} if x else 4.0")
        found = bridge_check.check_bridge(written(text.replace(FIX, pattern), "mine.py"))
        periods_s.append([found[f"period_{axis}_s"] for axis in "xyz"])
        assert found["weight_kn"] == pytest.approx(1.6e3 * G_MPS2, rel=1e-4)
        assert sum(mode.mass_rz for mode in found["modes"]) < 1.0 + 1e-6
    assert periods_s[0] == pytest.approx(periods_s[1], rel=1e-4)


def test_a_check_of_a_script_doubts_wrong_units(written):
    def doubts(text):
        found = bridge_check.check_bridge(written(text, "mine.py"))["findings"]
        return [finding.partition(" = ")[0] for finding in found if "check units" in finding]

    light, heavy = (GOOD.replace("share * 4.0e5", f"share * 4.0e{power}") for power in (2, 6))
    assert (doubts(GOOD), doubts(heavy)) == ([], ["weight over the area of the deck (kN/m2)"])
    assert "T1 (s)" in doubts(light)
    part = PATTERN + "; ops.load(3, 0.0, 0.0, -6.0e6, 0.0, 0.0, 0.0)"
    assert doubts(GOOD.replace(FIX, part)) == ["mass x g / dead load"]


def test_only_options_that_a_script_takes_act_on_its_elements(written):
    script, words = written(GOOD, "mine.py"), r"deck_mass_factor cannot act on .*mine\.py"
    with pytest.raises(InputError, match=words):
        _ = VariantOptions(bridge=script, changes=["deck_mass_factor=1.1"]).model
    for section in ({"model": {"deck_mass_factor": 1.1}}, {"grid": {"deck_mass_factor": [1.1]}}):
        config = parse_config(merged({"grid": {"bridge": [script]}}, section))
        with pytest.raises(InputError, match=words):
            check_inputs(config)
    text = GOOD.replace(HEAD, "def bridge(deck_mass_factor):")
    text = text.replace("share * 4.0e5", "deck_mass_factor * share * 4.0e5")
    variant = Variant.at(written(text, "mine.py"), "roller", USUAL)
    for factor in (1.0, 1.1):
        with domain():
            weight_n = build(variant, ModelOptions(deck_mass_factor=factor)).weight_n
        assert weight_n == pytest.approx(factor * 4 * 4.0e5 * G_MPS2)


def test_the_digest_covers_local_modules_and_data(tmp_path, written):
    text = f"import parts.deck\nfrom parts import column\nDATA = 'a.csv'\n{GOOD}"
    (tmp_path / "parts").mkdir()
    files = [tmp_path / name for name in ("parts/deck.py", "parts/column.py", "a.csv", "other.py")]
    for file in files:
        file.write_text("one = 1\n")
    path = written(text, "mine.py")
    digests = [load_structure(path).digest]
    for file in files:
        file.write_text("one = 2\n")
        digests.append(load_structure(path).digest)
    assert (len(set(digests)), digests[-1]) == (4, digests[-2])  # no one imports the last file


def test_abutments_are_those_of_the_script_of_osb1_or_of_an_option(written):
    osb1, other = map(catalogue.load_bridge, ("osb1", "bridge_a"))
    wider = 2 * osb1.deck.width_m

    def ends(own: str = ""):
        text = GOOD.replace("width=13.0 * M", f"width={wider}{own}")
        with domain():
            return [end.abutment for end in frame_of(written, text).ends]

    usual, _ = ends()
    assert usual.pads.yield_force_kn == pytest.approx(2 * osb1.abutment.pads.yield_force_kn)
    assert usual.wall_width_m == pytest.approx(2 * osb1.abutment.wall_width_m)
    assert wing_wall(usual).ultimate_n == pytest.approx(wing_wall(osb1.abutment).ultimate_n)
    pads = '{"count": 7, "plan_mm": 400, "rubber_mm": 60}'
    (given, _) = ends(f', abutment={{"pads": {pads}, "seat_width_m": {{"v": 0.5}}}}')
    drawn = {"count": 7, "height_m": 0.06, "shear_stiffness_kn_per_m": 1840.0}  # 690 x 0.16 / 0.06
    assert given.pads == usual.pads.model_copy(update=drawn | {"yield_force_kn": 55.2})
    assert given.seat_width_m == 0.5
    (chosen, _) = ends(', abutment="bridge_a"')
    assert chosen.seat_width_m == other.abutment.seat_width_m
    share = other.abutment.wall_width_m / other.deck.width_m
    assert chosen.wall_width_m == pytest.approx(share * wider)


def test_own_gap_and_skew_count_and_lengths_are_along_a_turned_and_moved_deck(written):
    own = 'units="N-m", abutment={"gap_mm": 30.0, "skew_deg": 20.0}'
    text = GOOD.replace('units="N-m"', own).replace("(0.05, 0.04)", "[0.05, 0.04]")
    text = text.replace("x * M, 0.0,", "84 / 85 * x, 13 / 85 * x + 90.0,")
    text = re.sub(r"(node\(1[01], 0.0,) 0.0", r"\1 90.0", text)
    about = load_structure(written(text, "mine.py")).description
    assert about.spans_m == pytest.approx((40.0, 40.0))
    assert about.columns_m[0] == pytest.approx((0.0, 0.0), abs=1e-9)
    assert about.gaps_mm == {"left": 30.0, "right": 30.0}
    assert about.axis_notes[1].endswith("gap_mm has no effect, though names of variants have it")
    with domain():
        skews_deg = {end.plan.name: end.plan.skew_deg for end in frame_of(written, text).ends}
    assert skews_deg == about.skews_deg == {"left": 20.0, "right": 20.0}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_the_scripts_of_the_documentation_run(script):
    result = run(str(script), "contact_friction", 20.0, 25.0, 4.0)
    for name in ("column_shear_dcr", "drift_over_capacity", "column_curvature_ductility"):
        assert np.isnan(result.demands[name]) == (script.stem == "viaduct")
    drift, residual = (result.demands[n] for n in ("column_drift_ratio", "energy_residual_ratio"))
    assert (result.status, drift > 0.0, abs(residual) < 0.01) == ("ok", True, True)
