"""Rules for the numbers that a drawing does not show: formulas of `rules.yaml`.

A formula uses keys of the bridge file, intermediate results and the functions of this module.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from itertools import product
from math import isfinite, pi, sqrt
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

import numpy as np

from skewbridge.bridge.catalogue.data import AbutmentData, BridgeData, IntegralData, JointData
from skewbridge.errors import InputError
from skewbridge.files.text import checked, errors_of, read_mapping, shortened
from skewbridge.units import GPA, INCH, KN, MM, MPA, quantity
from skewbridge.variant.axes import AXES

TABLES: Final = read_mapping(Path(__file__).parents[1] / "rules.yaml")

# --- functions of the formulas


def bar(text: str) -> tuple[float, ...]:
    """Return diameter (mm) and area (mm2) of a bar: ``#11`` or ``36 mm``."""
    if sizes := TABLES["bars"].get(text.strip()):
        return tuple(sizes)
    try:
        diameter_mm = quantity(text, "mm")
    except ValueError:
        names = ", ".join(TABLES["bars"])
        raise ValueError(f"must be one of {names} in quotes, or a size such as '16 mm'") from None
    return diameter_mm, pi / 4 * diameter_mm**2


def hoop(text: str) -> tuple[float, ...]:
    """Return diameter (mm), area (mm2) and spacing (mm) of hoops: ``#8 @ 5 in``."""
    name, separator, pitch = text.partition("@")
    if not separator:
        raise ValueError("must be a bar and its spacing, such as '#8 @ 5 in'")
    try:
        return *bar(name), quantity(pitch, "mm")
    except ValueError as error:
        if pitch.strip().replace(".", "", 1).isdigit():
            raise ValueError("needs a unit of the spacing, such as '#8 @ 127 mm'") from None
        raise error


def girder(text: str) -> tuple[float, ...]:
    """Return depth, area, centroid and inertia (m, m2, m4) of a girder such as ``AASHTO IV``."""
    if (sizes := TABLES["girders"].get(text)) is None:
        raise ValueError(f"must be one of {', '.join(TABLES['girders'])}")
    return tuple(size * INCH**power for size, power in zip(sizes, (1, 2, 1, 4), strict=True))


class Section(NamedTuple):
    """Gross section of a deck in m, m2 and m4, with its usual pads."""

    area: float
    centroid: float  # above the soffit
    vertical: float  # inertia for vertical bending
    transverse: float  # inertia for bending in plan
    torsion: float  # torsion constant
    void: float  # area that a solid diaphragm fills
    pads: int
    spacing: float  # of the pads


def box_section(
    width: float, depth: float, cells: int, top_mm: float, bottom_mm: float, web_mm: float,
    overhang: float,
) -> Section:  # fmt: skip
    """Return the section of a box girder; the overhang is measured to the middle of a web."""
    top, bottom, web = (MM * thickness_mm for thickness_mm in (top_mm, bottom_mm, web_mm))
    between, web_height = width - 2 * overhang, depth - top - bottom
    if between <= cells * web or web_height <= 0.0:
        raise ValueError("the plates and webs do not fit into the width and depth of the deck")
    webs, bottom_width, height = cells + 1, between + web, depth - (top + bottom) / 2
    webs_m = between * (np.arange(webs) / cells - 0.5)
    plates = [(width, top, depth - top / 2), (bottom_width, bottom, bottom / 2)]
    plates += [(web, web_height, bottom + web_height / 2)] * webs
    composite = _composed([(b * h, z, b * h**3 / 12) for b, h, z in plates])
    transverse = (top * width**3 + bottom * bottom_width**3 + webs * web_height * web**3) / 12
    transverse += web * web_height * float((webs_m**2).sum())
    torsion = 4 * (between * height) ** 2 / (between / top + between / bottom + 2 * height / web)
    void = (between - cells * web) * web_height
    return Section(*composite, transverse, torsion, void, webs, between / cells)


def girder_section(
    width: float, girder: tuple[float, ...], count: int, spacing: float, slab_mm: float
) -> Section:
    """Return the section of girders with a slab on top.

    References:
        AASHTO LRFD equation C4.6.2.2.1-2: torsion constant A^4 / 40 Ip of a stocky open section.
    """
    # ASSUME no haunches, the modulus of the slab for the girders, and Ip without the inertia about
    # the vertical axis, about a tenth of the other
    (depth, area, centroid, inertia), slab = girder, MM * slab_mm
    if (count - 1) * spacing > width:
        raise ValueError("the girders do not fit into the width of the deck")
    plate = (width * slab, depth + slab / 2, width * slab**3 / 12)
    composite = _composed([plate, *[(area, centroid, inertia)] * count])
    girders_m = spacing * (np.arange(count) - (count - 1) / 2)
    transverse = slab * width**3 / 12 + area * float((girders_m**2).sum())
    torsion = width * slab**3 / 3 + count * area**4 / (40 * inertia)
    void = max((count - 1) * (spacing * depth - area), 0.0)
    return Section(*composite, transverse, torsion, void, count, spacing)


def slab_section(width: float, thickness_mm: float) -> Section:
    """Return the section of a solid slab."""
    depth, pads = MM * thickness_mm, max(2, round(width / 3))  # ASSUME pads about 3 m apart
    area, i_vertical = width * depth, width * depth**3 / 12
    gross = area, depth / 2, i_vertical, depth * width**3 / 12, 4 * i_vertical, 0.0
    return Section(*gross, pads, width / pads)


def _composed(parts: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Return area, centroid and inertia of a section from those of each of its parts."""
    areas, centroids, inertias = np.array(parts).T
    centre = float(areas @ centroids / areas.sum())
    return float(areas.sum()), centre, float(inertias.sum() + areas @ (centroids - centre) ** 2)


def tallest(bents: list[dict[str, Any]], joints: Iterable[dict[str, Any]] = ()) -> float:
    """Return the largest height (m) of bents up to the soffit; 6 without bents."""
    caps_m = cap_areas(bents, 0.0, 1.0, joints)
    heights_m = [bent["clear_height_m"] + cap for bent, cap in zip(bents, caps_m, strict=True)]
    return max(heights_m, default=6.0)


def cap_areas(
    bents: list[dict[str, Any]], void: float, width: float = 0.0,
    joints: Iterable[dict[str, Any]] = (),
) -> list[float]:  # fmt: skip
    """Return the area (m2) that each cap adds to the deck: its voids, or the cap below bearings."""
    jointed = {joint.get("at") for joint in joints}
    return [
        width * bent["cap_depth_m"] if bent.get("pads") or f"bent {number}" in jointed else void
        for number, bent in enumerate(bents, start=1)
    ]


def is_fixed(base: str, bents: list[dict[str, Any]]) -> bool:
    """Return whether columns of the bridge or of any bent have a fixed base."""
    return "fixed" in {base, *(bent.get("base") for bent in bents)}


def is_concrete(modulus_gpa: float) -> bool:
    """Return whether a deck with this elastic modulus is of concrete."""
    # ASSUME a deck with a modulus above 100 GPa is steel or transformed to it
    return modulus_gpa <= 100.0


def cracked_ratio(bridge: BridgeData) -> float:
    """Return the stiffness of the columns at first yield / gross stiffness, mean of the bents."""
    from skewbridge.bridge.column import bent_capacities  # it imports the catalogue

    ratios: list[float] = []
    for bent in bent_capacities(bridge):
        gross = bent.column.outline.inertia_m4(int(bent.direction == "along"))
        cracked = bent.curve.first_yield_moment_nm / bent.curve.first_yield_curvature_per_m
        ratios.append(cracked / (bent.column.elastic_modulus_gpa * GPA * gross))
    return float(np.mean(ratios)) if ratios else 0.45


def axial_ratios(bridge: BridgeData, *_: object) -> list[float]:
    """Return dead load / expected strength of the gross section, for a column of each bent."""
    from skewbridge.bridge.weights import column_axial_n

    columns = [bridge.column_of(bent) for bent in bridge.bents]
    strengths = [c.expected_concrete_strength_mpa * MPA * c.outline.area_m2 for c in columns]
    return [column_axial_n(bridge, number) / strength for number, strength in enumerate(strengths)]


def bar_ratios(bridge: BridgeData, *_: object) -> list[float]:
    """Return the longitudinal reinforcement ratio of a column of each bent."""
    columns = map(bridge.column_of, bridge.bents)
    return [1e-6 * c.bar_count * c.bar_area_mm2 / c.outline.area_m2 for c in columns]


def end_reaction_kn(bridge: BridgeData, *_: object) -> float:
    """Return the larger dead-load reaction of the deck at its seats, or without one at its ends."""
    from skewbridge.bridge.weights import deck_reactions_n

    reactions_n = deck_reactions_n(bridge)
    ends_n: dict[str, float] = {"left": reactions_n[0], "right": reactions_n[-1]}
    if (reaction_n := max(ends_n[name] for name in bridge.seats or ends_n)) <= 0.0:
        raise ValueError("the deck lifts off its seats under dead load")
    return reaction_n / KN


def pads_reaction_kn(bridge: BridgeData, pads: Any, *_: object) -> float:
    """Return the dead-load reaction on the pads of a bent, or for other pads `end_reaction_kn`."""
    from skewbridge.bridge.weights import deck_reactions_n

    for bent, reaction_n in zip(bridge.bents, deck_reactions_n(bridge)[1:], strict=False):
        if bent.pads and bent.pads.model_dump() == pads:
            return reaction_n / KN
    return end_reaction_kn(bridge)


def period_s(bridge: BridgeData, which: Any) -> float:
    """Return the period ``t1``, ``long`` or ``short`` in s; see `bridge_period_s`."""
    # by name: the model of a bridge, which has these periods, imports the catalogue
    return import_module("skewbridge.bridge.assembly").bridge_period_s(bridge, which)


_FUNCTIONS: Final[dict[str, Any]] = {
    function.__name__: function
    for function in (
        axial_ratios, bar, bar_ratios, box_section, cap_areas, cracked_ratio, end_reaction_kn,
        girder, girder_section, hoop, is_concrete, is_fixed, max, min, pads_reaction_kn, period_s,
        round, slab_section, sqrt, tallest,
    )
} | {"pi": pi}  # fmt: skip

# --- formulas and rules

_NAMES: Final = re.compile(r"'[^']*'|(?<![\w.])[a-z]\w*(?:\.(?:\*|[a-z]\w*))*(?![\w(])")

#: Errors of a formula whose numbers do not fit together.
_FAULTS: Final = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)


class Formula:
    """Formula of `rules.yaml`; ``needs`` are the keys that it uses."""

    def __init__(self, text: str) -> None:
        words = dict.fromkeys(_NAMES.findall(text))
        self.text = text
        self.needs = [name for name in words if name[0] != "'" and name not in ("if", "else", "pi")]
        placeholders = {name: f"v[{number}]" for number, name in enumerate(self.needs)}
        code = _NAMES.sub(lambda match: placeholders.get(match[0], match[0]), text)
        self._function: Callable[[list[Any]], Any] = eval(f"lambda v: {code}", _FUNCTIONS)

    def value(self, lookup: Callable[[str], Any]) -> Any:
        """Return the value, or None if a number is unknown or the formula cannot be evaluated."""
        values = [lookup(key) for key in self.needs]
        if not all(map(_is_usable, values)):
            return None
        with suppress(*_FAULTS):
            return self.result(values)
        return None

    def result(self, values: list[Any]) -> Any:
        """Return the value of the formula from values of its keys, or raise one of `_FAULTS`."""
        with np.errstate(all="raise", under="ignore"):
            return self._function(values)


def _is_usable(value: Any) -> bool:
    if isinstance(value, int | float):
        return not isinstance(value, bool) and isfinite(value) and 0.0 <= value < 1.0e9
    return value is not None


class Rule(NamedTuple):
    """Rule that gives the number of one key."""

    key: str
    formula: Formula
    src: str
    within: float | None  # largest usual factor between a number in a file and the rule
    follows: list[str]  # keys on which the number depends
    any: Any  # valid number until these keys are known


def _rules() -> Iterator[Rule]:
    for row in TABLES["rules"]:
        formula = Formula(f"{row['is']}")
        conditions = row.get("within"), row.get("follows", formula.needs), row.get("any")
        yield Rule(row["key"], formula, row["src"], *conditions)


RULES: Final = tuple(_rules())
DRAWN: Final[Mapping[str, Any]] = TABLES["drawing"]
#: Types of ends with numbers that rules give.
_END_TYPES: Final = {"seat": AbutmentData, "integral": IntegralData}
_DECK_TYPES: Final[tuple[str, ...]] = ("deck.box", "deck.girders", "deck.slab")


def value_at(tree: Any, key: str) -> Any:
    """Return the value at a key such as ``bents.0.columns`` of mappings, lists and models."""
    for name in key.split("."):
        if isinstance(tree, list | tuple) and name.isdigit():
            tree = tree[int(name)] if int(name) < len(tree) else None
        else:
            tree = tree.get(name) if isinstance(tree, Mapping) else getattr(tree, name, None)
    return tree


def _sections(tree: Any, key: str) -> list[str]:
    """Return the sections to which a rule's key applies: ends of its type, joints and bents.

    The key starts with a type of end (``seat.pads``), or with ``abutment`` for all types with it.
    """
    kind, field, *_ = key.split(".")
    ends, joints = value_at(tree, "abutments"), value_at(tree, "joints")
    types = {"abutment": "seat"}
    if isinstance(ends, Mapping):
        types = {f"abutments.{name}": f"{value_at(ends, f'{name}.type')}" for name in ends}
    sections = [
        section
        for section, end_type in types.items()
        if kind in ("abutment", end_type)
        and end_type in _END_TYPES
        and field in _END_TYPES[end_type].model_fields
    ]
    is_of_joint = field in JointData.model_fields and isinstance(joints, list | tuple)
    sections += [f"joints.{number}" for number in range(len(joints) if is_of_joint else 0)]
    bents = value_at(tree, "bents") if field == "pads" else None
    numbers = range(len(bents) if isinstance(bents, list | tuple) else 0)
    return sections + [f"bents.{i}" for i in numbers if value_at(tree, f"bents.{i}.pads")]


def _is_of_end(key: str) -> bool:
    return key.partition(".")[0] in {"abutment", *_END_TYPES}


def places(tree: Any, keys: Collection[str]) -> Iterator[tuple[str, int]]:
    """Yield the (section of an end or joint, index of a bent) for which to evaluate a formula.

    A formula whose ``keys`` name no end, joint or bent is evaluated once.
    """
    of_ends, bents = [key for key in keys if _is_of_end(key)], value_at(tree, "bents")
    bent_count = len(bents) if isinstance(bents, list | tuple) else 0
    numbers = range(bent_count if any("*" in key for key in keys) else 1)
    return product(_sections(tree, of_ends[0]) if of_ends else ["abutment"], numbers)


def placed(key: str, section: str, number: int = 0) -> str:
    """Return a rule's key with its type of end replaced by a section, and ``*`` by a number."""
    key = re.sub(rf"^(abutment|{'|'.join(_END_TYPES)})\b", section, key)
    return key.replace("*", f"{number}")


def _keys(key: str, tree: Any) -> list[str]:
    """Return a rule's key for each end, joint and bent to which it applies; others unchanged."""
    return [placed(key, *place) for place in places(tree, [key])]


def _put(tree: Any, key: str, value: Any) -> None:
    """Set the value at a key in nested mappings and lists; do nothing if its section is neither."""
    *parents, final_key = key.split(".")
    for name in parents:
        if isinstance(tree, list) and name.isdigit():
            tree = tree[int(name)]
        elif isinstance(tree, dict):
            tree = cast("dict[str, Any]", tree).setdefault(name, {})
    if isinstance(tree, dict):
        tree[final_key] = value


def _rounded(value: Any, digits: int) -> Any:
    """Round numbers to significant digits: more depend on the processor, and run keys must not."""
    if isinstance(value, list):
        return [_rounded(item, digits) for item in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def _lookup(tree: Any, results: Mapping[str, Any], key: str) -> Any:
    """Return the number of a key from the bridge file, else from drawing or rules, or None."""
    candidates = value_at(tree, key), results.get(key), value_at(results, key)
    return next((value for value in candidates if value is not None), None)


def values_by_rule(given_numbers: Mapping[str, Any], tree: Any) -> Iterator[tuple[str, Any, Rule]]:
    """Yield key, value and rule of each rule that applies; formulas use numbers of the file first.

    ``given_numbers`` has the numbers of the drawing, and the whole ``bridge`` if it is complete.
    """
    results = dict(given_numbers)
    for rule in RULES:
        for place in places(tree, [rule.key]):
            key = placed(rule.key, *place)
            value = rule.formula.value(
                lambda need, place=place: _lookup(tree, results, placed(need, *place))
            )
            if key not in results and value is not None:
                results[key] = value
                yield key, value, rule


class Completed(NamedTuple):
    """A bridge, the keys of its drawing, the rules of derived numbers and the inherited keys."""

    bridge: BridgeData
    drawn: Mapping[str, Any]
    derived: Mapping[str, Rule]
    inherited: frozenset[str] = frozenset()

    def unused(self) -> list[str]:
        """Return the keys of the drawing without effect: the file has all numbers from them."""
        rules = [(rule.formula.needs, _parts(rule.key)) for rule in self.derived.values()]
        return [
            key
            for key, usual in ((key, _usual(key)) for key in self.drawn)
            if not any(usual in needs or _part(usual) in parts for needs, parts in rules)
        ]

    def by_rule(self) -> dict[str, tuple[Any, Rule]]:
        """Return value and rule of each key that a rule can give from the other numbers."""
        numbers = {**self.drawn, "bridge": self.bridge}
        rows = values_by_rule(numbers, self.bridge.model_dump(exclude={"sources"}))
        return {key: (value, rule) for key, value, rule in rows if _is_of_bridge(key)}


def _is_of_bridge(key: str) -> bool:
    return _usual(key) not in DRAWN and ("." in key or key in BridgeData.model_fields)


def _usual(key: str) -> str:
    """Return a key of one end, joint or bent in the general form that the rules use."""
    key = re.sub(r"^(abutments\.\w+|(joints|bents)\.\d+(?=\.pads))", "abutment", key)
    return re.sub(r"\.\d+\.", ".*.", key)


def completed(tree: dict[str, Any], path: Path) -> Completed:
    """Return the bridge of plain values and ``sources`` (``tree``); rules add missing numbers.

    `InputError` for a value that is invalid, or missing if no rule can give it.
    """
    where, derived = Path(path.name), dict[str, Rule]()
    for name in {axis.name for axis in AXES}.intersection(tree):
        text = "give it in the grid of the study, as an option, or under an end or joint"
        raise InputError(f"{where}: {name}: {text}", file=path.name)
    drawn = _take_drawn(tree, path.name)
    if tree.get("bents") == []:  # no columns: their keys are not needed
        tree |= {"base": tree.get("base", "pinned"), "column": tree.get("column")}
    for key, value, rule in values_by_rule(drawn, tree):
        if _is_of_bridge(key) and value_at(tree, key) is None:
            _put(tree, key, _rounded(value, 10))
            if value_at(tree, key) is not None:  # a null section stays
                derived[key] = rule
    after_others = {
        key: rule
        for rule in RULES
        for key in _keys(rule.key, tree)
        if rule.any is not None and value_at(tree, key) is None
        if tree.get(key.partition(".")[0], {}) is not None  # a null section stays
    }
    for key, rule in after_others.items():
        _put(tree, key, rule.any)
        derived[key] = rule
    tree["sources"] |= {key: rule.src for key, rule in derived.items()}
    try:
        bridge = checked(BridgeData, tree, where)
    except InputError as error:
        raise _explained(error, {**drawn, **derived}) from None
    for key, rule in after_others.items():
        try:
            value = rule.formula.result([bridge])
        except _FAULTS as error:
            text = f"cannot be computed from the other numbers ({error}); correct them or give it"
            raise InputError(f"{path.name}: {key}: {text}", file=path.name) from None
        _put(tree, key, _rounded(value, 4))
        bridge = checked(BridgeData, tree, where)
    return Completed(bridge, drawn, derived)


def without_drawing(tree: dict[str, Any], file: str) -> dict[str, Any]:
    """Return plain values in which rules have replaced the keys of a drawing (None: no value)."""
    keys, drawn = overruled(tree), _take_drawn(tree, file)
    values = {key: value for key, value, _ in values_by_rule(drawn, tree)}
    for key in keys:
        _put(tree, key, _rounded(values.get(key), 10))
    return tree


def _take_drawn(tree: dict[str, Any], file: str) -> dict[str, Any]:
    """Remove the keys of a drawing from a tree with plain values; return them, checked."""
    drawn: dict[str, Any] = {}
    for key, limits in ((key, limits) for k, limits in DRAWN.items() for key in _keys(k, tree)):
        parent_key, _, final_key = key.rpartition(".")
        section = value_at(tree, parent_key) if parent_key else tree
        if not isinstance(section, dict) or final_key not in section:
            continue
        value = drawn[key] = section.pop(final_key)
        try:
            if isinstance(limits, str):
                _FUNCTIONS[limits](f"{value}")
            elif type(value) not in (int, float) or not limits[0] <= value <= limits[1]:
                low, high, *words = limits
                raise ValueError(f"must be a number from {low:g} to {high:g}{''.join(words)}")
        except ValueError as error:
            raise InputError(f"{file}: {key}: {error}, got {shortened(value)}", file=file) from None
    kinds = [kind for kind in _DECK_TYPES if any(key.startswith(f"{kind}.") for key in drawn)]
    if len(kinds) > 1:
        raise InputError(f"{file}: give only one of {' and '.join(kinds)}", file=file)
    if isinstance(deck := tree.get("deck"), dict):
        tree["deck"] = {key: value for key, value in deck.items() if value != {}}
    return drawn


def overruled(tree: Mapping[str, Any]) -> set[str]:
    """Return inherited keys without effect: rules compute them from the drawing in the file."""
    keys_without_effect: set[str] = set()
    for seat in _sections(tree, "seat.pads") or ["abutment"]:
        drawn = {_part(key) for key in DRAWN if value_at(tree, placed(key, seat)) is not None}
        keys = {rule.key for rule in RULES if drawn.intersection(_parts(rule.key))}
        keys |= set[str]() if drawn.isdisjoint(_DECK_TYPES) else {*_DECK_TYPES}
        keys_without_effect |= {placed(key, seat) if "*" not in key else key for key in keys}
    return {key for key in keys_without_effect if value_at(tree, key) is None}


def _explained(error: InputError, known: Iterable[str]) -> InputError:
    """Return the error, extended by the part of a drawing that would give each missing number.

    ``known`` are the keys from the drawing or a rule. Errors that follow from these keys are listed
    only if there are no others.
    """
    file, lines = f"{error.details['file']}", error.details["errors"]
    faulty = {_usual(line.partition(": ")[0]) for line in lines}
    reported: list[str] = []
    consequences: dict[str, str] = {}
    for line in lines:
        key, is_missing, _ = line.partition(": is missing")
        parts = _parts(_usual(key)) if is_missing else {}
        drawn = [part for part in parts if any(f"{name}.".startswith(f"{part}.") for name in known)]
        if drawn:
            text = f"its numbers are incomplete or do not fit together, so {key} is missing"
            consequences.setdefault(drawn[0], f"{drawn[0]}: {text}")
        elif line.partition(": ")[0] in known:
            consequences[line] = line
        elif parts:
            reported.append(f"{line}; or give {' or '.join(parts)}")
        elif not is_missing or not _follows(_usual(key), faulty):
            reported.append(line)
    return errors_of(file, reported or list(consequences.values()), file=file)


def _follows(key: str, faulty: Collection[str]) -> bool:
    """Return whether a rule of a key needs a faulty number, directly or in stages."""
    needs = (need for rule in RULES if rule.key == key for need in rule.formula.needs)
    return any(need in faulty or _follows(need, faulty) for need in needs)


def _parts(key: str) -> dict[str, None]:
    """Return the parts of a drawing from which rules derive a key, directly or in stages."""
    rule_keys = {rule.key for rule in RULES}
    parts: dict[str, None] = {}
    for needed in (needed for rule in RULES if rule.key == key for needed in rule.formula.needs):
        is_drawn = needed in DRAWN and needed not in rule_keys
        parts |= {_part(needed): None} if is_drawn else _parts(needed.partition(".")[0])
    return parts


def _part(key: str) -> str:
    """Return the part of a drawing to which a key belongs, such as ``deck.box``."""
    return next((kind for kind in _DECK_TYPES if key.startswith(f"{kind}.")), key)
