"""Bridge files: of the catalogue, of users and from drawings; messages for bad files; doubts."""

import random
import re
from itertools import combinations
from math import pi, sqrt
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from reference_pages import ROOT

from bridge_variants import variant
from reference_data import BAD
from skewbridge.analysis.bridge_check import check_bridge, doubts
from skewbridge.bridge.catalogue import FOLDER, BridgeData, bridge_names, load_bridge, read_bridge
from skewbridge.bridge.catalogue.drawing import box_section, girder, girder_section, value_at
from skewbridge.bridge.model import build, domain
from skewbridge.errors import InputError
from skewbridge.files.text import checked, read_json, read_mapping
from skewbridge.units import KIP, MN, quantity, unit_in_name
from skewbridge.variant.options import ModelOptions

BRIDGE_SCHEMA = jsonschema.Draft202012Validator(read_json(ROOT / "config/bridge.schema.json"))
OWN = "extends: osb1\nsource: 'd: x'\n"
WALL = "column: {shape: rectangular, width_m: 5.0, depth_m: 1.0, bar_count: 44, tie_legs: [4, 8]}\n"
PLAIN = ("drawing S-12", "Drawing S-12: section B", "p. 14", "as-built, 1998", "design code")
MISTAKES = ("e: drawing", "B: drawing", "b:drawing", "b: ", "b", "calc", "calc:3", "", "  ")
INTEGRAL = "abutments: {{left: {{type: {}}}, right: {{type: roller}}}}"
K50 = """abutment:
  wall_height_m: 1.4
  backfill: {rule: k50, stiffness_mn_per_m: 28.0, ultimate_kn: 2000, ultimate_closure_ratio: 0.05}
"""
TEMPLATE = ROOT / "config/bridges/template.yaml"
DRAWINGS = sorted((ROOT / "tests/data/drawings").glob("*.yaml"))
MAOC, STEEL, UNEQUAL, WALLS = map(DRAWINGS[0].with_stem, ("maoc", "steel", "unequal", "walls"))
PADS = {"plan_mm": 400, "rubber_mm": 50}
GIRDERS = {"type": "BT-63", "count": 5, "spacing_m": 2.9, "slab_mm": 215}
SLIPS = {
    "m": (3.2808, 39.37, 1000), "mm": (25.4, 1000), "m2": (10.764, 1e6), "m4": (115.86, 1e12),
    "mm2": (645.16, 1e6), "gpa": (6.895, 1000), "mpa": (6.895, 1000), "kn": (4.448, 1000),
    "kn/m": (4.448, 14.594, 1000), "mn/m": (5.71, 68.5, 1000), "mnm/rad": (737.6, 1000),
    "kn/m3": (6.366, 1000), "t": (2.2046, 1000), "s": (1000,),
}  # fmt: skip


@pytest.mark.parametrize("name", bridge_names())
def test_every_number_of_a_bridge_names_its_source_class(name: str) -> None:
    bridge = load_bridge(name)
    assert len(bridge.sources) > 60
    assert {source.split(":")[0] for source in bridge.sources.values()} <= set("abcd") | {"calc"}


def test_a_fixed_base_without_foundation_stands_on_the_springs_of_bridge_a(written) -> None:
    typical, osb1 = load_bridge("bridge_a"), load_bridge("osb1")
    sprung = load_bridge(written("extends: osb1\nbase: fixed\n"))
    assert sprung.foundation == typical.foundation is not None
    assert sprung.sources["foundation.krx_mnm_per_rad"] == "b: PyPBEE Bridge_A"
    bent = osb1.bents[0].model_dump(exclude_none=True) | {"columns": 1}
    single = load_bridge(written(f"{OWN}base: fixed\n{yaml.safe_dump({'bents': [bent]})}"))
    assert single.foundation == typical.foundation
    assert load_bridge(written("extends: osb1\nbase: fixed\nfoundation: null\n")).foundation is None


def test_a_user_adds_a_bridge_by_a_file_in_which_nothing_is_missing(written) -> None:
    bridge = load_bridge(written("extends: osb1\ndeck: {width_m: {v: 15.0, src: 'd: wider'}}\n"))
    assert (bridge.deck.width_m, bridge.sources["deck.width_m"]) == (15.0, "d: wider")
    assert (bridge.name, bridge.deck.depth_m) == ("made", load_bridge("osb1").deck.depth_m)


def bents(columns: int = 1, **keys: object) -> str:
    bent = {"columns": columns, "clear_height_m": 5.0, "cap_width_m": 2.0, "cap_depth_m": 1.8}
    return yaml.safe_dump({"bents": [bent | {"cap_weight_kn": 500} | keys]})


def test_a_bent_replaces_single_keys_of_the_column_and_the_base(written) -> None:
    oblong = {"shape": "oblong", "width_m": 3.0, "depth_m": 1.2}
    path = written(OWN + bents(base="fixed", column=oblong))
    bridge = load_bridge(path)
    column, (bent,) = bridge.column_of(bridge.bents[0]), bridge.bents
    assert (bridge.base_of(bent), bridge.base) == ("fixed", "pinned")
    assert bridge.foundation == load_bridge("bridge_a").foundation
    inherited = column.model_dump(exclude={"shape", "width_m", "depth_m", "cross_ties"})
    assert inherited == bridge.column.model_dump(exclude={"shape", "diameter_m"})
    assert (column.shape, column.width_m, bridge.column.shape) == ("oblong", 3.0, "circular")
    assert bridge.sources["bents.0.column.width_m"] == "d: x"
    # without cross ties, two legs resist the pressure on the width, as on the depth
    (depth, width), hoops = column.core.sizes_m, column.hoops
    assert hoops.confining[0] / hoops.confining[1] == pytest.approx(depth / width)
    ring_m2 = column.core.length_m * 510e-6 / 0.127
    assert hoops.volume_ratio == pytest.approx(ring_m2 / column.core.area_m2)
    # a single column needs no spacing
    assert (bent.columns, bent.column_spacing_m) == (1, 0.0)
    with domain():
        assert len(build(variant(bridge=path), ModelOptions()).columns) == 1
    # another shape in a file that extends a bridge, too
    wall = load_bridge(written(f"extends: made\nsource: 'd: x'\n{WALL}"))
    assert wall.column.tie_legs == (4, 8)
    assert wall.column.bar_area_mm2 == load_bridge("osb1").column.bar_area_mm2


def test_a_source_without_a_letter_is_a_document_at_hand(written) -> None:
    for text in PLAIN:
        path = written(f'extends: osb1\nt1_s: {{v: 0.7, src: "{text}"}}\n')
        assert BRIDGE_SCHEMA.is_valid(read_mapping(Path(path)))
        assert load_bridge(path).sources["t1_s"] == f"b: {text}"
    for value in (*(f'"{text}"' for text in MISTAKES), "12", "[S-12]", "null"):
        path = written(f"extends: osb1\nt1_s: {{v: 0.7, src: {value}}}\n")
        assert not BRIDGE_SCHEMA.is_valid(read_mapping(Path(path)))
        with pytest.raises(InputError, match=r"t1_s: src must be"):
            load_bridge(path)


@pytest.mark.parametrize(
    ("text", "key", "limit"),
    [
        *BAD["bridges"],
        (K50, "backfill.stiffness_mn_per_m", "at least 28.57 with rule k50"),
        (WALL.replace("[4, 8]", "[4]"), "column.tie_legs.1", "is missing"),
        (WALL.replace("44", "45"), "column", "bar_count must be even, got 45"),
        (WALL.replace("5.0", "20.0"), "bents.0: the columns span 27.32 m", "deck.width_m"),
        (bents(base="hinged"), "bents.0.base", "pinned"),
        (INTEGRAL.format("integral, gap_mm: 20"), "left.gap_mm", "unknown key of this type"),
        (INTEGRAL.format("pinned"), "abutments.left.type", "one of 'seat', 'integral', 'fixed'"),
        (bents(clear_hight_m=5.0), "bents.0.clear_hight_m", "(did you mean bents.clear_height_m?)"),
        (bents(columns=2), "bents.0", "column_spacing_m is missing or 0: 2 columns need it"),
        (bents(clear_height_m=240.0) + "deck: {soffit_height_m: 240.0}",  # inches
         "bents.0.clear_height_m", "must be at most 40 x the column width = 67.04, got 240"),
    ],
)  # fmt: skip
def test_a_bad_value_names_file_key_and_limit(written, text, key, limit):
    with pytest.raises(InputError) as caught:
        load_bridge(written(OWN + text))
    assert all(part in str(caught.value) for part in ("made.yaml", key, limit))


def test_unknown_or_circular_parents_are_refused(written) -> None:
    unknown, one, other = (written(f"extends: {name}\n") for name in ("osb9", "made2", "made1"))
    for path, words in (
        (unknown, "osb9"),
        (one, r"made2\.yaml: extends: no other bridge is named 'made1'"),
        (other, r"made1\.yaml: extends: no other bridge is named 'made2'"),
    ):
        with pytest.raises(InputError, match=words):
            load_bridge(path)


def test_an_own_bridge_is_found_by_its_name_before_the_catalogue(tmp_path, monkeypatch):
    own = tmp_path / "config/bridges"
    own.mkdir(parents=True)
    (own / "mine.yaml").write_text("extends: osb1\nbase: fixed\n", encoding="utf-8")
    (own / "osb1.yaml").write_text("extends: osb1\ntitle: mine\n", encoding="utf-8")
    before = load_bridge("osb1").title
    monkeypatch.chdir(tmp_path)
    assert load_bridge("osb1").title == "mine" != before
    assert (load_bridge("mine").base, load_bridge("mine").title) == ("fixed", "mine")
    assert load_bridge("config/bridges/mine.yaml") == load_bridge("mine")
    with pytest.raises(InputError, match=r"bridge must be one of .* mine.* got 'osb9'"):
        load_bridge("osb9")


def test_the_schema_of_editors_knows_the_form_of_a_bridge() -> None:
    for path in (*FOLDER.glob("*.yaml"), *(ROOT / "config/bridges").glob("*.yaml")):
        BRIDGE_SCHEMA.validate(read_mapping(path))
    for bad in ({"extends": "osb1", "deck": {"depth_m": "six"}}, {"title": "one key only"}):
        assert not BRIDGE_SCHEMA.is_valid(bad)


def leaves(node: object, above: str = ""):
    if not isinstance(node, dict | list | tuple):
        yield above, node
        return
    for key, value in node.items() if isinstance(node, dict) else enumerate(node):
        yield from leaves(value, f"{above}.{key}".lstrip("."))


def drawn(written, changes: dict[str, object]) -> Path:
    tree = yaml.safe_load(TEMPLATE.read_text(encoding="utf-8"))
    for key, value in changes.items():
        *above, last = (int(part) if part.isdigit() else part for part in key.split("."))
        node = tree
        for part in above:
            node = node[part]
        if value is None:
            del node[last]
        else:
            node[last] = value
    return Path(written(yaml.safe_dump(tree)))


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("150 ft", "m", 45.72), ("5'-6\"", "m", 1.6764), ("5' 6 1/2\"", "mm", 1689.1),
        ('8.5"', "mm", 215.9), ("4 ksi", "mpa", 27.579), ("1.56 in^2", "mm2", 1006.45),
        ("150 pcf", "kn/m3", 23.563), ("12 kip/ft", "kn/m", 175.127),
        ("50 kip/in", "mn/m", 50 * KIP / 0.0254 / MN), ("1000 kip-ft/rad", "mnm/rad", 1.35582),
        ("8 1/4 in", "mm", 209.55), ("131 ft 6 in", "m", 40.0812), ("11/2 in", "mm", 139.7),
        ("13.2 lbm", "t", 0.0059874), ("0.5 s", "s", 0.5), ("6 m", "mm", 6000.0),
    ],
)  # fmt: skip
def test_a_quantity_is_converted_to_the_unit_of_its_key(text, unit, value) -> None:
    assert quantity(text, unit) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(("key", "value", "words"), BAD["drawings"])
def test_a_bad_drawing_names_key_value_and_need(written, key, value, words) -> None:
    with pytest.raises(InputError) as caught:
        load_bridge(drawn(written, {key: value}))
    message = str(caught.value)
    assert words in message
    assert key.partition(".")[0] in message or key == "source"
    assert "abutment.wall_height_m" not in message  # missing only because the depth is


def test_integral_and_fixed_ends_are_completed_from_a_deck_in_text(written) -> None:
    ends = {"left": {"type": "integral", "piles": {"count": 8}}, "right": {"type": "fixed"}}
    deck = {"deck.width_m": "42 ft", "deck.box": None, "deck.girders": GIRDERS}
    own = drawn(written, deck | {"abutment": None, "abutments": ends})
    left = load_bridge(own).ends["left"]
    assert (left.wall_width_m, left.wall_height_m) == pytest.approx((42 * 0.3048, 6 * 0.3048))
    assert left.wall_thickness_m == 0.915  # rule of the end diaphragm
    assert left.piles.spacing_m == pytest.approx(42 * 0.3048 / 8, abs=1e-4)
    assert "abutments.left.piles.lateral_kn_per_m" in read_bridge(own).derived


def test_more_pads_than_the_rule_has_are_spread_over_a_solid_slab(written) -> None:
    slab = {"deck.box": None, "deck.depth_m": None, "deck.slab": {"thickness_mm": 700}}
    slab |= {"deck.width_m": 34, "spans_m": [14, 14], "abutment.pads": {"count": 12} | PADS}
    read = read_bridge(drawn(written, slab))
    assert read.bridge.seat.pads.spacing_m == pytest.approx(34 / 12)  # for 11 pads: 34 / 11
    # its area is the whole rectangle
    assert not [doubt for doubt in doubts(read) if "area of the deck / (" in doubt]


def test_girders_on_joints_are_completed_and_vibrate_as_simple_spans(written) -> None:
    simple = {"base": "fixed", "deck.box": None, "deck.depth_m": None, "deck.girders": GIRDERS}
    simple |= {"spans_m": [32, 26], "bents.0.cap_depth_m": 1.3}
    simple["bents.0.clear_height_m"] = 5.63881234543  # the height of the soffit has ten digits
    simple["joints"] = [{"at": "bent 1", "seat_width_m": 0.6, "pads": PADS}]
    read = read_bridge(drawn(written, simple))
    assert "cap_depth_m" not in "\n".join(doubts(read))  # below bearings, not as deep as the deck
    own = read.bridge
    pads, deck = own.joints[0].pads, own.deck
    assert (pads.count, deck.diaphragm_thickness_m) == (5, 0.305)  # rules for girders
    assert deck.soffit_height_m == pytest.approx(own.bents[0].clear_height_m + 1.3)
    assert pads.shear_stiffness_kn_per_m == pytest.approx(0.69 * 400**2 / 50)  # G A / h
    mass_kg_per_m = deck.line_load_kn_per_m * 1e3 / 9.80665
    rigidity_nm2 = deck.elastic_modulus_gpa * 1e9 * deck.inertia_vertical_m4
    vertical_s = 2 / pi * 32**2 * sqrt(mass_kg_per_m / rigidity_nm2)  # first mode of a simple span
    # pads and bent soften the spans, the set-back pads shorten them
    assert own.damping.short_period_s == pytest.approx(vertical_s, rel=0.05)
    assert own.damping.long_period_s < 1.1 * own.t1_s  # no span swings about its joint


def test_wrong_numbers_are_reported_without_what_follows_from_them(written) -> None:
    loose = r"damping\.long_period_s: .* no equilibrium under dead load.*"
    thick = r"deck\.box: its numbers .* do not fit together, so deck\.area_m2 is missing"
    # a rule for the hoops of rectangular columns exists only before 1971
    ties = dict.fromkeys(("column.diameter_m", "column.hoop")) | {"column.shape": "rectangular"}
    ties |= {"column.width_m": 1.7, "column.depth_m": 1.7, "column.tie_legs": [4, 4]}
    assert load_bridge(drawn(written, ties | {"year": 1965})).column.hoop_spacing_mm == 305.0
    late = ties | {"year": 1980}, r"year: its numbers .*, so column\.hoop_spacing_mm is missing"
    plates = {"deck.box.top_mm": 990, "deck.box.bottom_mm": 990}
    hinge = {"from_left_m": 60, "ledge": "right", "seat_width_m": 0.6, "pads": PADS}
    hinged = {"base": "fixed", "joints": [hinge]}
    bent = {"columns": 2, "column_spacing_m": 7.0, "clear_height_m": 6.0}
    short = {"spans_m": [15, 60, 15], "bents": [bent, bent]}
    lifted = r"abutment\.sacrificial_key\.force_kn: .* lifts off its seats .*; correct .*"
    cases = [(plates, thick), (hinged, loose), late, (short, lifted)]
    for key, limit, value in (
        ("deck.width_m", 100, 504), ("column.diameter_m", 10, 66),  # inches
        ("column.cover_to_hoop_m", 0.5, 50), ("deck.diaphragm_thickness_m", 10, 900),  # mm
    ):  # fmt: skip
        words = rf"{re.escape(key)}: must be less than or equal to {limit}, got {value}"
        cases.append(({key: value}, words))
    for changes, words in cases:
        own = drawn(written, changes)
        with pytest.raises(InputError, match=rf"^{own.name}: {words}$"):
            load_bridge(own)


def test_the_template_needs_at_most_25_entries_and_each_of_them(written) -> None:
    tree = yaml.safe_load(TEMPLATE.read_text(encoding="utf-8"))
    keys = {re.sub(r"(?<=spans_m)\.\d", "", key) for key, _ in leaves(tree)} - {"source", "details"}
    assert len(keys) <= 25
    for key in keys:
        with pytest.raises(InputError, match=r"missing|number|items"):
            load_bridge(drawn(written, {key: None}))


def test_osb1_from_its_drawing_has_the_numbers_of_its_file(written) -> None:
    drawing = {"deck.width_m": 14.33, "deck.box.overhang_m": "4.5 ft"}
    drawing["column.concrete_strength_mpa"] = 27.6
    read, osb1 = read_bridge(drawn(written, drawing)), load_bridge("osb1")
    skipped = {"name", "title", "sources"}
    known = dict(leaves(osb1.model_dump(exclude=skipped)))
    for key, value in leaves(read.bridge.model_dump(exclude=skipped)):
        is_number = isinstance(value, float)
        assert value == (pytest.approx(known[key], rel=0.02) if is_number else known[key]), key
    assert len(read.derived) > 50
    assert {"t1_s", "bents.0.cap_weight_kn", "deck.torsion_constant_m4"} <= read.derived.keys()
    assert read.bridge.sources["t1_s"].startswith("calc: model with pads")
    own = read_bridge(drawn(written, drawing | {"t1_s": 0.7}))
    assert (own.bridge.t1_s, "t1_s" in own.derived) == (0.7, False)


def test_sections_agree_with_published_ones() -> None:
    # La Veta (bridge B of PyPBEE) with the plates of osb1
    box = box_section(23.01, 1.899, 7, 216, 178, 305, 1.37)
    bridge = load_bridge("bridge_b").deck
    inertia_m4 = (bridge.inertia_vertical_m4, bridge.inertia_transverse_m4)
    published = (bridge.area_m2, *inertia_m4, bridge.torsion_constant_m4)
    found = (box.area, box.vertical, box.transverse, box.torsion)
    assert found == pytest.approx(published, rel=0.03)
    # an AASHTO IV girder under a slab of 96 x 8 in, by hand in inches
    beams = girder_section(96 * 0.0254, girder("AASHTO IV"), 1, 2.0, 8 * 25.4)
    centre = (789 * 24.73 + 768 * 58) / 1557
    inertia = 260_730 + 789 * (centre - 24.73) ** 2 + 96 * 8**3 / 12 + 768 * (58 - centre) ** 2
    assert beams.vertical == pytest.approx(inertia * 0.0254**4, rel=1e-9)


@pytest.mark.parametrize("path", DRAWINGS, ids=lambda path: path.stem)
def test_a_bridge_from_a_general_plan_raises_no_doubts(path: Path) -> None:
    found = check_bridge(str(path))
    assert doubts(read_bridge(path)) == []
    assert found["t1_of_the_model_s"] == pytest.approx(found["t1_of_the_file_s"], rel=0.01)
    assert {"number", "value", "rule"} == set(found["derived"][0])
    BRIDGE_SCHEMA.validate(yaml.safe_load(path.read_text()))


def test_slips_in_a_drawing_are_named_with_the_rule_of_a_derived_number(written) -> None:
    piles = {"count": 6, "lateral_kn_per_m": 40, "lateral_strength_kn": 40}  # kip and inch
    ends = {key: {"type": "integral", "piles": piles} for key in ("left", "right")}
    slips = {"bents.0.clear_height_m": 18.5, "deck.barriers_kn_per_m": 0.82}  # ft, kip/ft
    for changes, words in (
        ({"deck.line_load_kn_per_m": 190, "deck.barriers_kn_per_m": 12}, {"m has no effect: the"}),
        (slips, {"(by rule, d: clear height plus deck depth)", "barriers_kn_per_m = 0.82 is"}),
        ({"abutment": None, "abutments": ends}, {"kn_per_m is 0.0057 times", "kn is 0.22 times"}),
    ):
        text = "\n".join(doubts(read_bridge(drawn(written, changes))))
        assert all(part in text for part in words)


def test_maoc_has_the_section_and_backfill_of_its_source() -> None:
    bridge = load_bridge(MAOC)
    assert [bent.clear_height_m for bent in bridge.bents] == [9.0, 9.6, 9.36, 8.36]
    soil, column = bridge.abutment.backfill, bridge.column
    assert (soil.stiffness_mn_per_m, soil.ultimate_kn) == pytest.approx((263.08, 3024.3), rel=1e-4)
    assert column.bar_area_mm2 == pytest.approx(pi / 4 * 34.3**2)
    steel_mm2 = column.bar_count * column.bar_area_mm2
    assert 1e-6 * steel_mm2 / column.outline.area_m2 == pytest.approx(0.019, rel=0.01)


def test_a_drawing_replaces_inherited_numbers_and_stale_ones_are_named(written) -> None:
    text = "extends: osb1\nsource: 'b: S-1'\n"
    read = read_bridge(written(f"{text}deck: {{slab: {{thickness_mm: 1829}}}}\n"))
    assert read.bridge.deck.area_m2 == pytest.approx(14.33 * 1.829)
    assert read.bridge.deck.line_load_kn_per_m == 186.2  # inherited, and far too small now
    assert any("deck.line_load_kn_per_m is 0.3 times 629" in doubt for doubt in doubts(read))
    path = written(f"{text}spans_m: [200 ft, 200 ft]\n")
    stale = doubts(read_bridge(path))[-1]
    assert stale.startswith("numbers are inherited although")
    keys = {"damping.short_period_s", "abutment.sacrificial_key.force_kn"}
    assert keys <= set(re.findall(r"[\w.]+", stale))
    found = check_bridge(path)
    assert found["sources"] == f"1 b, {len(found['inherited'])} inherited, 0 by rule"
    assert "deck.width_m" in found["inherited"]


@pytest.mark.parametrize(
    ("bridge", "changes", "words"),
    [
        ("osb1", {"deck.inertia_vertical_m4": 114.5, "deck.inertia_transverse_m4": 3.778},
         "vertical inertia of the deck / (area x depth squared) = 4.63"),
        ("osb1", {"column.bar_area_mm2": 100.6}, "column.bar_area_mm2 is 0.1 times 1007"),
        ("osb1", {"column.bar_area_mm2": 12.6, "column.bar_diameter_mm": 4.0}, "the usual 0.005"),
        ("osb1", {"abutment.backfill.stiffness_mn_per_m": 20_300.0}, "is 1000 times 20.3"),
        ("osb1", {"bents.0.column_spacing_m": 3.0}, "= 0.209 is outside the usual 0.3 to 0.95 or"),
        ("osb1", {"abutment.wall_height_m": 2.5}, "abutment.wall_height_m is 1.4 times 1.829"),
        ("osb1", {"t1_s": 1.2}, "t1_s is 1.7 times 0.71"),
        (UNEQUAL, {"bents.1.column.bar_diameter_mm": 4.3}, "bents.1.column.bar_diameter_mm = 4.3"),
        (UNEQUAL, {"bents.1.cap_depth_m": 0.15}, "bents.1.cap_depth_m = 0.15 is outside"),
        (WALLS, {"foundation.krx_mnm_per_rad": 500.0}, "of a column along its bent = 0.009"),
        (STEEL, {"deck.line_load_kn_per_m": 10.5}, "weight of the deck per area (kN/m2) = 0.875"),
    ],
)  # fmt: skip
def test_a_doubtful_number_is_named_with_its_usual_range(bridge, changes, words) -> None:
    assert words in "\n".join(doubts(changed(bridge, changes)))


def test_a_column_of_one_bent_has_bars_hoops_and_a_cap_of_its_own() -> None:
    first, second, _ = load_bridge(UNEQUAL).bents
    found = second.column.bar_area_mm2, second.column.hoop_area_mm2, second.column.hoop_spacing_mm
    assert found == (1452, 510, 127)
    caps_m = [bent.cap_width_m / 0.3048 for bent in (first, second)]  # columns + 2 ft
    assert caps_m == pytest.approx([4.5 + 2, 7 + 2])


def changed(name, changes):
    read = read_bridge(name)
    tree = read.bridge.model_dump()
    for key, value in changes.items():
        above, _, last = key.rpartition(".")
        (value_at(tree, above) if above else tree)[last] = value
    return read._replace(bridge=checked(BridgeData, tree, name))


def is_caught(name: str, *slips: tuple[str, float]) -> bool:
    bridge = load_bridge(name)
    values = {key: np.multiply(value_at(bridge, key), factor).tolist() for key, factor in slips}
    try:
        text = "\n".join(doubts(changed(name, values)))
    except InputError as error:
        text = str(error)
    said, *keys = (re.sub(r"\.\d+\.", ".*.", part) for part in (text, *values))
    return any(key in said or key.rpartition(".")[2] in said for key in keys)


@pytest.mark.parametrize("name", bridge_names())
def test_a_bridge_of_the_catalogue_is_plausible(name: str) -> None:
    bridge = read_bridge(name)
    # numbers from recordings of the bridge may differ from the rules
    sources = bridge.bridge.sources.items()
    recorded = [key for key, source in sources if "record" in source or "fitted:" in source]
    assert [doubt for doubt in doubts(bridge) if not any(key in doubt for key in recorded)] == []


@pytest.mark.parametrize("name", ["osb1", "bridge_a", "osb2s"])
def test_slips_of_units_are_named_alone_and_in_pairs(name: str) -> None:
    bridge, chance = load_bridge(name), random.Random(44)
    known = [key for key in bridge.sources if value_at(bridge, key) and unit_in_name(key)]
    factors = {unit: [*up, *(1 / factor for factor in up)] for unit, up in SLIPS.items()}
    slips = [(key, factor) for key in known for factor in factors[unit_in_name(key)]]
    pairs = [pair for pair in combinations(slips, 2) if pair[0][0] != pair[1][0]]
    cases = [*((slip,) for slip in chance.sample(slips, 40)), *chance.sample(pairs, 60)]
    assert [case for case in cases if not is_caught(name, *case)] == []
