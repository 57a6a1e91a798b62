"""A user's own OpenSeesPy script as a bridge: its frame, checked and completed from the domain."""

from bisect import bisect
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise, takewhile
from math import asin, cos, degrees, hypot, inf, nan, radians, sqrt
from numbers import Real
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.assembly import (
    GravityError,
    assemble,
    domain,
    modes_of,
    period_s,
    solver_log,
)
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import AbutmentData
from skewbridge.bridge.catalogue.drawing import without_drawing
from skewbridge.bridge.frame import Damping, DeadLoad, Description, End, Frame
from skewbridge.bridge.handles import ColumnCapacity, ColumnHandle, Point, TagAllocator
from skewbridge.bridge.plan import DeckEnd, PlanVector
from skewbridge.bridge.script_files import (
    FRAME_NUMERICS,
    FRAME_OPTIONS,
    FUNCTION,
    call_script,
    files_digest,
    lines_of,
    parameters,
    script_files,
)
from skewbridge.bridge.script_frame import Column
from skewbridge.bridge.script_frame import End as ScriptEnd
from skewbridge.bridge.script_frame import Frame as ScriptFrame
from skewbridge.bridge.script_units import (
    FORCE,
    LENGTH,
    MOMENT,
    PER_LENGTH,
    SiView,
    UnitSystem,
    view_constraints,
)
from skewbridge.bridge.structures import built_end, widened
from skewbridge.contact.element import FIRST_FREE_MATERIAL
from skewbridge.errors import InputError
from skewbridge.files.text import checked, merged
from skewbridge.units import G_MPS2
from skewbridge.variant.axes import USUAL
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

#: Bridge of the catalogue with the default abutments.
DEFAULT_ABUTMENT: Final = "osb1"
#: ASSUME an elastic beam this many times stiffer than the median, also in bending, is a link.
_STIFF: Final = 20.0
#: Columns closer along the bridge than this share of its length, at zero skew, are one bent.
_BENT_SHARE: Final = 0.05
_DRAWN_M: Final = ((0.7, 0.7), (-0.7, 0.7), (-0.7, -0.7), (0.7, -0.7))  # columns of the sketch
_BEAM: Final = 12  # components of the forces of an element with two nodes
#: Position of the transformation after the tag of an element.
_TRANSFORMATION_AT: Final = {
    "elasticBeamColumn": 8, "ElasticTimoshenkoBeam": 10, "forceBeamColumn": 2,
    "dispBeamColumn": 2, "nonlinearBeamColumn": 4,
}  # fmt: skip
#: ASSUME a vector this close to the axis of an element is meant to be parallel to it.
_LEAST_ANGLE_DEG: Final = 0.1
_LEAST_SOFFIT_M: Final = 0.01
#: ASSUME a deck this close to x is meant to be along x; demands mix by the sine, at most 17 %.
_LARGEST_TURN_DEG: Final = 10.0


@dataclass(frozen=True, slots=True)
class ScriptBridge:
    """Bridge of a script: a `Structure`."""

    path: Path
    digest: str

    @property
    def name(self) -> str:
        """Name of the script without its ending."""
        return self.path.stem

    @property
    def t1_s(self) -> float:
        """Conditioning period, stated by the script or from its modes at zero skew."""
        return _common_properties(self).t1_s

    @property
    def description(self) -> Description:
        """Description for pages, printed tables and checks."""
        return _common_properties(self).description

    @property
    def ignored(self) -> frozenset[str]:
        """Modelling options of deck and columns that are not parameters of the script."""
        return (FRAME_OPTIONS | FRAME_NUMERICS).difference(parameters(self.path))

    def build(self, skew_deg: float, options: ModelOptions, tags: TagAllocator) -> Frame:
        """Run the script in the open domain and complete its frame; see `Structure`."""
        damping = _common_properties(self).damping
        # the first call has emptied the domain
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        frame, _ = self.frame(skew_deg, options, tags)
        periods = damping.long_period_s, damping.short_period_s
        bents, at = _common_properties(self).bents, f"at skew {skew_deg:g}"
        if len(frame.columns) != len(bents):
            text = f"columns: {len(frame.columns)} {at}, {len(bents)} at skew 0: give the same ones"
            raise InputError(f"{self.path}: {text}")
        columns = [replace(c, bent=bent) for c, bent in zip(frame.columns, bents, strict=True)]
        return replace(
            frame,
            columns=tuple(columns),
            damping=replace(frame.damping, long_period_s=periods[0], short_period_s=periods[1]),
        )

    def frame(
        self, skew_deg: float, options: ModelOptions, tags: TagAllocator
    ) -> tuple[Frame, ScriptFrame]:
        """Return the frame (damping periods nan if not stated) and that of the script."""
        files, names = script_files(self.path), parameters(self.path)
        values = {"skew_deg": skew_deg} | {
            name: getattr(options, name) for name in names if name != "skew_deg"
        }
        with _axes_checked():
            answer = call_script(files, {name: values[name] for name in names})
        with lines_of(files):
            if not isinstance(answer, ScriptFrame):
                raise InputError(f"{FUNCTION}() must return a skewbridge.Frame, got {answer!r}")
            return _Reader(answer, tags, skew_deg, options).frame(), answer


def load_script(path: Path) -> ScriptBridge:
    """Return the bridge of a script; an `InputError` names file and line."""
    files = script_files(path.resolve())
    parameters(files[0])
    return ScriptBridge(files[0], files_digest(files))


@dataclass(frozen=True, slots=True, kw_only=True)
class _CommonProperties:
    """Properties common to all variants, from the model with pads and open gaps at zero skew."""

    t1_s: float
    damping: Damping
    description: Description
    bents: tuple[int, ...]  # number of the bent of each column, from the left


@contextmanager
def _reasons() -> Generator[None]:
    """Add the last OpenSees message to an `InputError` for a refused command; drop the others."""
    with TemporaryDirectory() as folder:
        log = Path(folder) / "opensees.log"
        try:
            with solver_log(log):
                yield
        except InputError as error:
            lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
            reasons = [
                " ".join(line.split()).removeprefix("WARNING ") for line in lines if line.strip()
            ]
            if not reasons or type(error.__cause__).__name__ != "OpenSeesError":
                raise
            raise InputError(f"{error}: {reasons[-1]}", **error.details) from error


@cache
def _common_properties(bridge: ScriptBridge) -> _CommonProperties:
    """Return these properties from a model at zero skew, which empties the open domain."""
    frames: list[tuple[Frame, ScriptFrame]] = []

    def build(*arguments: Any) -> Frame:
        frames.append(bridge.frame(*arguments))
        return frames[0][0]

    variant = Variant.at(str(bridge.path), "contact_friction", USUAL)
    with _reasons(), lines_of([bridge.path]), domain():
        try:
            model = assemble(build, variant, ModelOptions())
        except GravityError as error:
            raise InputError(f"{error}, with the deck ends on pads") from error
        modes = modes_of(model)
        (frame, stated), periods = frames[0], {d: period_s(modes, d) for d in "xyz"}
        bents = _bents(frame)
        turns = "skew_deg" in parameters(bridge.path)
        description = replace(_description(bridge.name, frame, stated, bents), bents_turn=turns)
    long_s, short_s = stated.damping_periods or (max(periods.values()), min(periods.values()))
    damping = replace(frame.damping, long_period_s=long_s, short_period_s=short_s)
    t1_s = stated.t1 or sqrt(periods["x"] * periods["y"])
    return _CommonProperties(t1_s=t1_s, damping=damping, description=description, bents=bents)


def _columns_m(frame: Frame) -> tuple[list[PlanVector], float]:
    """Return column tops from mid-deck, along and across the deck, and its length (m)."""
    left, right = (np.array(end.plan.middle_m) for end in frame.ends)
    length_m = float(np.linalg.norm(right - left))
    along = (right - left) / length_m
    tops = [np.array(ops.nodeCoord(column.top.node)[:2]) for column in frame.columns]
    offsets = [top - (left + right) / 2 for top in tops]
    across = np.array([-along[1], along[0]])
    return [(float(offset @ along), float(offset @ across)) for offset in offsets], length_m


def _bents(frame: Frame) -> tuple[int, ...]:
    """Return the number (0, 1, ...) of the bent of each column, from left to right."""
    columns_m, length_m = _columns_m(frame)
    starts: list[float] = []
    for x, _ in sorted(columns_m):
        if not starts or x - starts[-1] >= _BENT_SHARE * length_m:
            starts.append(x)
    return tuple(bisect(starts, x) - 1 for x, _ in columns_m)


def _description(
    name: str, frame: Frame, script_frame: ScriptFrame, numbers: Sequence[int]
) -> Description:
    columns_m, length_m = _columns_m(frame)
    seats = [(end, end.abutment) for end in frame.ends if isinstance(end.abutment, AbutmentData)]
    bents: list[list[tuple[float, float]]] = [[] for _ in {*numbers}]
    for column, (x, _), number in zip(frame.columns, columns_m, numbers, strict=True):
        bents[number].append((x, column.clear_height_m))
    middles_m = (fmean(x for x, _ in bent) for bent in bents)
    supports_x = [-length_m / 2, *middles_m, length_m / 2]
    return Description(
        title=script_frame.title or name,
        details="script",
        spans_m=tuple(b - a for a, b in pairwise(supports_x)),
        width_m=frame.ends[0].plan.width_m,
        bent_heights_m=tuple(fmean(height for _, height in bent) for bent in bents),
        bent_columns=tuple(map(len, bents)),
        columns_m=tuple(columns_m),
        bent_bases=("",) * len(bents),
        outlines_m=(_DRAWN_M,) * len(columns_m),
        seats_m={end.plan.name: seat.seat_width_m for end, seat in seats},
        end_kinds={end.plan.name: seat.type for end, seat in seats},
        skews_deg={
            end.plan.name: seat.skew_deg for end, seat in seats if seat.skew_deg is not None
        },
        gaps_mm={end.plan.name: seat.gap_mm for end, seat in seats if seat.gap_mm is not None},
        keys_at={end.plan.name: seat.keys_at for end, seat in seats},
        wall_m=max(seat.wall_thickness_m for _, seat in seats),
        backfill_rule="".join({seat.backfill.rule for _, seat in seats}),
        damping_ratio=frame.damping.ratio,
    )


def _need(condition: bool, message: str) -> None:
    if not condition:
        raise InputError(message)


@contextmanager
def _axes_checked() -> Generator[None]:
    """Inside the context, refuse beams without length or with a geomTransf vector along their axis.

    OpenSees would end the process silently. Also refused is what could not be read from the domain:
    masses of elements, and factors of loads.
    """
    vectors: dict[Any, tuple[np.ndarray, np.ndarray]] = {}
    commands = ops.geomTransf, ops.element, ops.timeSeries, ops.pattern

    def transformation(kind: str, tag: int, *values: Any) -> None:
        arguments = [value for value in values if not isinstance(value, str)]
        offsets = arguments[3:9] if "-jntOffset" in values else [0.0] * 6
        vectors[tag] = np.array(arguments[:3]), np.subtract(offsets[3:], offsets[:3])
        commands[0](kind, tag, *values)

    def loading(command: Callable[..., None], *values: Any) -> None:
        for word in ("-fact", "-factor"):
            is_one = _after(word, values, 1.0) == 1.0
            _need(is_one, f"omit {word}: the numbers of load commands are the dead load")
        command(*values)

    def element(kind: str, tag: int, *values: Any) -> None:
        is_massless = _after("-mass", values, 0.0) == 0.0
        _need(is_massless, f"element {tag}: give its mass to nodes, without -mass")
        arguments = list(takewhile(lambda value: not isinstance(value, str), values))
        index = _TRANSFORMATION_AT.get(kind, len(arguments))
        if kind == "elasticBeamColumn" and len(arguments) <= index:
            index = 3  # its section comes first
        if index < len(arguments) and arguments[index] in vectors:
            _check_axes(tag, values[:2], arguments[index], *vectors[arguments[index]])
        commands[1](kind, tag, *values)

    ops.geomTransf, ops.element = transformation, element
    ops.timeSeries, ops.pattern = (partial(loading, command) for command in commands[2:])
    try:
        yield
    finally:
        ops.geomTransf, ops.element, ops.timeSeries, ops.pattern = commands


def _require_space() -> None:
    ndm, ndf = (next(iter(query() or [0])) for query in (ops.getNDM, ops.getNDF))
    _need(
        (ndm, ndf) == (3, 6),
        f"the model must have 3 dimensions and 6 degrees of freedom, got {ndm} and {ndf}",
    )


def _after(word: str, values: Sequence[Any], default: float) -> Any:
    """Return the value after a word among the values of a command."""
    return values[values.index(word) + 1] if word in values[:-1] else default


def _check_axes(
    element: int, nodes: Sequence[int], transformation: int, vector: np.ndarray, offset: np.ndarray
) -> None:
    _require_space()
    start, stop = map(np.array, map(ops.nodeCoord, nodes))
    axis = stop - start + offset
    length_product = float(np.linalg.norm(axis) * np.linalg.norm(vector))
    _need(length_product > 0.0, f"element {element} or the vector of its geomTransf has no length")
    sine = float(np.linalg.norm(np.cross(axis, vector))) / length_product
    angle_deg = degrees(asin(min(sine, 1.0)))
    _need(
        angle_deg >= _LEAST_ANGLE_DEG,
        f"geomTransf {transformation}: its vector {vector.tolist()} must be at least "
        f"{_LEAST_ANGLE_DEG:g} degrees off the axis {axis.tolist()} of element {element}, got "
        f"{angle_deg:.2g}",
    )


class _Reader:
    """Completes the frame that a script has returned with data of the domain that it has built."""

    def __init__(
        self, script_frame: ScriptFrame, tags: TagAllocator, skew_deg: float, options: ModelOptions
    ) -> None:
        self._stated, self._skew_deg, self._options = script_frame, skew_deg, options
        ends = script_frame.ends
        self._ends = [end if isinstance(end, ScriptEnd) else ScriptEnd(end) for end in ends]
        self._units = units = UnitSystem.named(script_frame.units)
        _require_space()
        self._nodes, self._elements = _listed(ops.getNodeTags()), _listed(ops.getEleTags())
        _need(bool(self._elements), "the model has no elements")
        self._joined: dict[int, list[int]] = {}
        for element in self._elements:
            for node in _listed(ops.eleNodes(element)):
                self._joined.setdefault(node, []).append(element)
        constrained = _listed(ops.getConstrainedNodes())
        held = {*constrained, *(n for c in constrained for n in _listed(ops.getRetainedNodes(c)))}
        idle = (n for n in self._nodes if n not in self._joined and n not in held)
        free_node = next((n for n in idle if len(_listed(ops.getFixedDOFs(n))) < 6), None)
        _need(
            free_node is None, f"node {free_node} has neither elements nor constraints: delete it"
        )
        moved_node = next((n for n in self._nodes if any(ops.nodeDisp(n))), None)
        _need(
            moved_node is None and ops.getTime() == 0.0,
            f"{FUNCTION}() must only build the model, but it has run an analysis"
            f"{'' if moved_node is None else f': node {moved_node} has moved'}",
        )
        self._loads = self._dead_load()
        largest = {"node": max(self._nodes), "element": max(self._elements)}
        largest["parameter"] = max(_listed(ops.getParamTags()), default=0)
        # OpenSees cannot list the others
        kinds = ("material", "section", "integration", "transformation", "series", "pattern")
        tags.start_above(dict.fromkeys((*kinds, "region"), FIRST_FREE_MATERIAL) | largest)
        if units != UnitSystem():
            SiView(units, tags)
        if _listed(ops.getConstrainedNodes()):
            view_constraints()

    def frame(self) -> Frame:
        """Return the frame in SI, the left end first."""
        script, loads, end_count = self._stated, self._loads, len(self._ends)
        self._must_have("ends", [end.node for end in self._ends])
        _need(end_count == 2, f"ends must be the two end nodes of the deck, got {end_count}")
        ends = sorted(self._ends, key=lambda end: ops.nodeCoord(end.node, 1))
        columns = tuple(self._column(number, row) for number, row in enumerate(script.columns))
        bases = dict.fromkeys(column.element for column in columns)
        two_node = [e for e in self._elements if len(_listed(ops.eleResponse(e, "force"))) == _BEAM]
        beams = [e for e in two_node if len(set(map(self._place, ops.eleNodes(e)))) > 1]
        self._check_columns(beams, bases)
        damped = tuple(_soft(beams) if script.damped is None else script.damped)
        self._must_have("damped", damped, "element")
        elastic = [e for e in damped if ops.eleType(e) == "ElasticBeam3d" and e not in bases]
        links = [e for e in beams if ops.eleType(e) == "ElasticBeam3d" and e not in damped]
        plastic = [e for e in two_node if e not in {*elastic, *links, *bases}]
        # of what can move
        held = {n: {*_listed(ops.getFixedDOFs(n))} for n in self._nodes}
        free = [n for n in self._nodes if not {1, 2, 3} <= held[n]]
        masses = {n: float(ops.nodeMass(n, 1)) for n in free if any(ops.nodeMass(n))}
        _need(bool(masses), "the model has no nodal masses: give them with ops.mass")
        if loads is None:
            z_masses = {node: float(ops.nodeMass(node, 3)) for node in masses}
            massless = next((n for n, mass in z_masses.items() if mass == 0.0 < masses[n]), None)
            _need(massless is None, f"node {massless} has no mass along z: add it, or give loads")
            loads = {node: G_MPS2 * mass for node, mass in z_masses.items()}, {}
        periods = script.damping_periods or (nan, nan)
        return Frame(
            centre_node=self._centre(masses, [*elastic, *links]),
            loads=DeadLoad(
                forces_n={n: force for n, force in loads[0].items() if 3 not in held[n]},
                moments_nm=loads[1],
                masses_kg=masses,
            ),
            ends=tuple(self._end(*side) for side in self._sides(ends)),
            columns=columns,
            damping=Damping(
                ratio=script.damping_ratio,
                long_period_s=max(periods),
                short_period_s=min(periods),
                elements=damped,
            ),
            elements={"columns": (*bases, *plastic), "deck": (*elastic,), "links": (*links,)},
            units=None if self._units == UnitSystem() else self._units,
        )

    def _must_have(self, field: str, tags: Iterable[Any], kind: str = "node") -> None:
        existing = self._nodes if kind == "node" else self._elements
        for tag in tags:
            _need(tag in existing, f"{field}: the model has no {kind} {tag!r}")

    def _dead_load(self) -> tuple[dict[int, float], dict[int, tuple[float, float]]] | None:
        """Remove the dead load; return downward forces and moments about x, y by node, or None."""
        script, unit_n, unit_nm = self._stated, self._units.si(FORCE), self._units.si(MOMENT)
        patterns = _listed(ops.getPatterns())
        if script.loads is not None:
            self._must_have("loads", script.loads)
            _need(not patterns, "give the dead load as loads or as a load pattern, not as both")
            return {node: unit_n * load for node, load in script.loads.items()}, {}
        if not patterns:
            return None
        _need(
            not _listed(ops.getEleLoadTags()),
            "element loads are not supported: give nodal loads, or no loads to use mass x g",
        )
        values = np.reshape(ops.getNodeLoadData(), (-1, 6)) * [*[unit_n] * 3, *[unit_nm] * 3]
        forces: dict[int, float] = {}
        moments: dict[int, tuple[float, float]] = {}
        for node, (x, y, vertical, about_x, about_y, about_z) in zip(
            _listed(ops.getNodeLoadTags()), values.tolist(), strict=True
        ):
            is_vertical = not (x or y or about_z)
            _need(is_vertical, f"the dead load of node {node} must be along z (x along, z up)")
            forces[node] = forces.get(node, 0.0) - vertical
            moment = moments.get(node, (0.0, 0.0))
            moments[node] = moment[0] + about_x, moment[1] + about_y
        for pattern in patterns:
            ops.remove("loadPattern", pattern)
        return (forces, moments) if forces else None

    def _place(self, node: int) -> tuple[float, ...]:
        return tuple(ops.nodeCoord(node))

    def _sides(self, ends: Sequence[ScriptEnd]) -> list[tuple[ScriptEnd, str, PlanVector]]:
        """Return each end with its name and the direction to it from the other end."""
        (x1, y1, _), (x2, y2, _) = (self._place(end.node) for end in ends)
        distance = hypot(x2 - x1, y2 - y1)
        axis = (x2 - x1) / distance if distance else 0.0, (y2 - y1) / distance if distance else 0.0
        _need(
            axis[0] >= cos(radians(_LARGEST_TURN_DEG)),
            f"the deck must be within {_LARGEST_TURN_DEG:g} degrees of x, as demands are along "
            f"x and y: turn the model; its ends are at ({x1:g}, {y1:g}) and ({x2:g}, {y2:g})",
        )
        return [(ends[0], "left", (-axis[0], -axis[1])), (ends[1], "right", axis)]

    def _end(self, script_end: ScriptEnd, side: str, from_other: PlanVector) -> End:
        script, unit_m = self._stated, self._units.si(LENGTH)
        node, position = script_end.node, self._place(script_end.node)
        _need(
            not ops.getFixedDOFs(node),
            f"ends: node {node} must not be fixed, because the abutments of skewbridge support it: "
            f"delete its fix of {_listed(ops.getFixedDOFs(node))}",
        )
        for element in self._joined.get(node, ()):
            nodes = _listed(ops.eleNodes(element))
            grounds = [n for n in nodes if {1, 2, 3} <= {*_listed(ops.getFixedDOFs(n))}]
            _need(
                not grounds,
                f"ends: element {element} supports node {node} on the fixed nodes {grounds}: "
                "delete it, because the abutments of skewbridge support the ends",
            )
        outward = script_end.outward or self._outward(node, from_other)
        length = hypot(*outward)
        width, soffit = (
            unit_m * (getattr(script, name) if value is None else value)
            for name, value in (("width", script_end.width), ("soffit", script_end.soffit))
        )
        _need(width > 0.0, f"width must be positive, got {width / unit_m:g}")
        # the stiff arms of the joint may not be parallel to the vector of their transformation
        _need(
            soffit >= _LEAST_SOFFIT_M,
            f"soffit must be at least {_LEAST_SOFFIT_M / unit_m:.3g}, got {soffit / unit_m:g}",
        )
        data, thickness_m = _abutment(script_end.abutment or script.abutment, width)
        plan = DeckEnd(
            side,
            (position[0], position[1]),
            (outward[0] / length, outward[1] / length),
            self._skew_deg if data.skew_deg is None else data.skew_deg,
            width,
            thickness_m,
            position[2] - soffit,
        )
        return End(node=node, plan=plan, abutment=built_end(data, self._options))

    def _outward(self, node: int, from_other: PlanVector) -> PlanVector:
        """Return the direction of the element at an end that points most out of the deck."""
        x, y, _ = self._place(node)
        neighbours = {n for e in self._joined.get(node, ()) for n in ops.eleNodes(e)} - {node}
        directions = [(x - self._place(n)[0], y - self._place(n)[1]) for n in neighbours]
        directions = [(dx / hypot(dx, dy), dy / hypot(dx, dy)) for dx, dy in directions if dx or dy]
        _need(bool(directions), f"ends: node {node} must be the end of a deck element")
        return max(directions, key=lambda v: v[0] * from_other[0] + v[1] * from_other[1])

    def _column(self, number: int, column: Column) -> ColumnHandle:
        field, unit_m = f"columns.{number}", self._units.si(LENGTH)
        self._must_have(f"{field}.element", [column.element], "element")
        self._must_have(field, [column.base, column.top])
        start_node = _listed(ops.eleNodes(column.element))[0]
        _need(
            start_node == column.base,
            f"{field}: element {column.element} must start at the base, node {column.base}, but "
            f"starts at node {start_node}",
        )
        base_z, top_z = self._place(column.base)[2], self._place(column.top)[2]
        height_m = top_z - base_z if column.height is None else unit_m * column.height
        _need(
            0.0 < height_m <= top_z - base_z + 1e-6 * abs(top_z),
            f"{field}: height must be above 0 and at most {(top_z - base_z) / unit_m:g}, from base "
            f"to top along z, got {height_m / unit_m:g}",
        )
        fixed = _listed(ops.getFixedDOFs(column.base))
        is_pinned = self._joined[column.base] == [column.element] and not {4, 5} <= {*fixed}
        yield_curvature = column.yield_curvature
        _need(
            yield_curvature is None or bool(column.hinges),
            f"{field}: yield_curvature needs hinges, the integration points of the hinges",
        )
        for point in column.hinges:
            response = ("section", f"{point}", "deformation")
            _need(
                bool(_listed(ops.eleResponse(column.element, *response))),
                f"{field}.hinges: element {column.element} has no integration point {point}",
            )
        drift, per_m = column.drift_capacity, self._units.si(PER_LENGTH)
        drifts = tuple(drift) if isinstance(drift, Sequence) else (drift, drift)
        _need(len(drifts) == 2, f"{field}.drift_capacity must be a number or two, got {drift}")
        strength = None if callable(column.shear_strength) else column.shear_strength
        limits = {"drift_capacity": (*drifts, 1.0), "yield_drift": (column.yield_drift, 1.0)}
        limits |= {"shear_strength": (strength, inf), "yield_curvature": (yield_curvature, inf)}
        for name, (*values, limit) in limits.items():
            words = "must be positive" if limit == inf else f"must be above 0 and at most {limit:g}"
            for value in values:
                is_valid = value is None or (isinstance(value, Real) and 0.0 < value <= limit)
                _need(is_valid, f"{field}.{name} {words}, got {value}")
        stated, unit_n = column.shear_strength, self._units.si(FORCE)
        shear = None if stated is None else partial(_strength_n, stated, unit_n)

        def capacity(drift_ratio: float | None) -> ColumnCapacity:
            return ColumnCapacity(
                yield_curvature_per_m=nan if yield_curvature is None else yield_curvature * per_m,
                yield_drift_ratio=nan if column.yield_drift is None else column.yield_drift,
                drift_capacity_ratio=nan if drift_ratio is None else drift_ratio,
                shear=shear,
            )

        return ColumnHandle(
            element=column.element,
            base_node=column.base,
            top=Point(column.top, (0.0, 0.0, base_z + height_m - top_z)),
            clear_height_m=height_m,
            hinge_sections=tuple(column.hinges),
            capacities=(capacity(drifts[0]), capacity(drifts[1])),
            is_pinned=is_pinned,
        )

    def _check_columns(self, beams: Iterable[int], columns: Iterable[int]) -> None:
        """Refuse an upright beam that stands on the ground below the deck and is no column."""
        parts = [_listed(ops.eleNodes(e)) for e in self._elements if e not in columns]
        constrained = _listed(ops.getConstrainedNodes())
        parts += [[node, *_listed(ops.getRetainedNodes(node))] for node in constrained]
        reached = {end.node for end in self._ends}
        while linked := [p for p in parts if 0 < len(reached.intersection(p)) < len({*p})]:
            reached.update(*linked)
        fixed = (node for node in reached if {1, 2, 3} <= {*_listed(ops.getFixedDOFs(node))})
        supports = {self._place(node) for node in fixed}
        for element in (e for e in beams if e not in columns):
            low, high = sorted(map(self._place, ops.eleNodes(element)), key=lambda place: place[2])
            is_upright = high[2] - low[2] > hypot(high[0] - low[0], high[1] - low[1])
            _need(
                not (is_upright and low in supports),
                f"columns: element {element} stands on a support below the deck: add its column",
            )

    def _centre(self, masses: Mapping[int, float], deck: Iterable[int]) -> int:
        """Return the stated centre node, or the deck node nearest to the mass centre in plan."""
        if (centre := self._stated.centre) is not None:
            self._must_have("centre", [centre])
            return centre
        positions, weights = np.array([self._place(node) for node in masses]), [*masses.values()]
        x, y, _ = np.average(positions, axis=0, weights=weights)
        deck_nodes = dict.fromkeys(int(node) for element in deck for node in ops.eleNodes(element))
        top = max(self._place(end.node)[2] for end in self._ends)

        def distance(node: int) -> tuple[float, float]:
            position = self._place(node)
            return round(hypot(position[0] - x, position[1] - y), 3), abs(position[2] - top)

        return min(deck_nodes or masses, key=distance)


def _strength_n(
    strength: float | Callable[..., Any], unit_n: float, axial_n: Any, drift: Any, curvature: Any
) -> Any:
    if not callable(strength):
        return np.full_like(axial_n, strength * unit_n)
    return unit_n * np.asarray(strength(axial_n / unit_n, drift, curvature), dtype=np.float64)


def _abutment(source: str | Mapping[str, Any] | None, width_m: float) -> tuple[AbutmentData, float]:
    """Return data of an abutment for a deck width, and the thickness of the end diaphragm (m)."""
    source_bridge = load_bridge(source if isinstance(source, str) else DEFAULT_ABUTMENT)
    data = widened(source_bridge.seat, width_m / source_bridge.deck.width_m)
    if isinstance(source, Mapping):
        stated = without_drawing({"abutment": _plain(source)}, "Frame")["abutment"]
        data = checked(AbutmentData, merged(data.model_dump(), stated), "abutment")
    return data, source_bridge.deck.diaphragm_thickness_m


def _plain(value: Any) -> Any:
    """Return nested data whose numbers may have sources, as in a file, without the sources."""
    if not isinstance(value, Mapping):
        return value
    return value["v"] if "v" in value else {key: _plain(item) for key, item in value.items()}


def _soft(beams: Sequence[int]) -> list[int]:
    """Return the beam-columns that are not stiff links; damping of links is rounding error only."""
    elastic = [e for e in beams if ops.eleType(e) == "ElasticBeam3d"]
    if not elastic:
        return list(beams)
    # along the axis and in bending
    stiffness = np.array([np.diag(np.reshape(ops.basicStiffness(e), (6, 6)))[:5] for e in elastic])
    is_link = (stiffness > _STIFF * np.median(stiffness, axis=0)).any(axis=1)
    links = {e for e, is_stiff in zip(elastic, is_link, strict=True) if is_stiff}
    return [e for e in beams if e not in links]


def _listed(tags: Any) -> list[int]:
    """Return tags as a list; OpenSees returns a number for one tag and may return None."""
    return [] if tags is None else [int(tags)] if isinstance(tags, int | float) else list(tags)
