"""Commands for single bridges: catalogue, checks, modes, static pushes, columns, drawings."""

import re
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from skewbridge.cli import COMMANDS, new_group
from skewbridge.cli.output import (
    DEFAULT_BRIDGE,
    Abutment,
    Answer,
    Out,
    VariantOptions,
    arg,
    command,
    failure_notes,
    gap_notes,
    opt,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import shortened, writable_folder, write_text
from skewbridge.units import INCH, KN, Units
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, BRIDGE_PATTERN, Variant

if TYPE_CHECKING:
    from skewbridge.analysis.pushover import PushCurve

LADDER_ANGLES_DEG: Final = (0.0, 30.0, 60.0, 90.0, 150.0, 180.0)
_OF_RUN: Final = ("demands", "capacities", "histories")  # tables of `run` that `sdc` reads
Name = Annotated[str | None, arg("Bridge, instead of --bridge.", "[NAME|FILE]")]
_DIRECTION: Final = opt(
    "x (longitudinal, default), y or degrees, counter-clockwise.",
    "[x|y|DEG]",
    *("--direction", "--angle-deg"),
)
OptionalOut = Annotated[Path | None, opt("Folder for the table.")]
MaxDisp = Annotated[float, opt("Final displacement of the push, in m.")]


@dataclass(frozen=True, kw_only=True)
class PushOptions:
    """Direction and output folder of a push."""

    out: Out
    direction: Annotated[list[str] | None, _DIRECTION] = None

    @property
    def angle_deg(self) -> float:
        """Angle from x in degrees, counter-clockwise; `InputError` for two directions."""
        first, *more = self.direction or ["x"]
        if more:
            both = f"{shortened(first)} and {shortened(more[0])}"
            raise InputError(f"--direction and --angle-deg are one option: drop one of {both}")
        angle_deg = nan
        with suppress(ValueError):
            angle_deg = float({"x": "0", "y": "90"}.get(first, first))
        if not isfinite(angle_deg):
            raise InputError(f"--direction must be x, y or degrees, got {shortened(first)}")
        return angle_deg


commands = new_group()
bridge = new_group(name="bridge", help=COMMANDS["bridge"][1])
commands.add_typer(bridge)


@bridge.callback()
def _drop_solver_messages(context: typer.Context) -> None:
    from skewbridge.bridge.assembly import solver_log

    context.with_resource(solver_log(None))


def _write(columns: Any, folder: Path, name: str) -> None:
    import pandas as pd

    pd.DataFrame(columns).to_parquet(writable_folder(folder) / f"{name}.parquet", index=False)


def _known_bridges() -> list[str]:
    from skewbridge.bridge.catalogue import OWN_FOLDER, bridge_names

    return [*bridge_names(), *(path.stem for path in sorted(OWN_FOLDER.glob("*.yaml")))]


_TWO_BRIDGES: Final = "{} and --bridge {} are two bridges: omit one"


@dataclass(frozen=True, kw_only=True)
class NamedBridge:
    """A bridge that may be a positional argument."""

    name: Name = None
    bridge: Annotated[str, opt("Name or file of a bridge; default: osb1.", "NAME|FILE")] = ""

    def __post_init__(self) -> None:
        """Take the positional argument as the bridge, unless another one is given as option."""
        if self.name and self.bridge not in ("", self.name):
            raise InputError(_TWO_BRIDGES.format(self.name, self.bridge))
        object.__setattr__(self, "bridge", self.name or self.bridge or DEFAULT_BRIDGE)


@dataclass(frozen=True, kw_only=True)
class NamedVariantOptions(NamedBridge, VariantOptions):
    """Options of a variant of a bridge that may be a positional argument."""


@command(bridge, "list")
def list_bridges() -> Answer:
    """List the bridges of the catalogue and those in config/bridges.

    Example: skewbridge bridge list
    """
    from skewbridge.bridge.catalogue import load_bridge

    rows, unreadable = list[dict[str, Any]](), list[str]()
    for name in _known_bridges():
        try:
            data = load_bridge(name)
        except InputError as error:
            unreadable.append(f"{name} is left out: {error}")
            continue
        sizes = {"length_m": data.length_m, "bents": len(data.bents), "t1_s": data.t1_s}
        rows.append({"bridge": name, "title": data.title, **sizes})
    return Answer({"bridges": rows}, warnings=unreadable)


@command(bridge)
def check(
    case: NamedBridge,
    units: Units,
    out: Annotated[Path | None, opt("Folder of the drawing; default results/bridges/NAME.")] = None,
) -> Answer:
    """Check a bridge: keys, weight, axial loads, periods and capacities; draw its model.

    Everything that would stop or distort a study is reported; exits with 2 if the file is invalid.

    Example: skewbridge bridge check config/bridges/mine.yaml
    """
    from skewbridge.analysis.bridge_check import check_bridge
    from skewbridge.study.config import stated_values

    answer = check_bridge(case.bridge)
    picture = writable_folder(out or Path("results/bridges") / answer["bridge"]) / "model.png"
    values = {"skew_deg": 30.0, "gap_mm": 51.0, "friction": 0.5} | stated_values(case.bridge)
    _draw_model(Variant.at(case.bridge, "contact_friction", values), ModelOptions(), picture, units)
    answer |= {"picture": str(picture), "modes": [asdict(mode) for mode in answer["modes"]]}
    printed = {name: value for name, value in answer.items() if name not in ("findings", "modes")}
    sections = Counter(key.partition(".")[0] for key in answer["inherited"])
    printed["inherited"] = ", ".join(f"{count} of {name}" for name, count in sections.items())
    if not re.fullmatch(BRIDGE_PATTERN, answer["bridge"]):
        text = "studies need a name of lowercase letters, digits and _ that starts with a letter"
        answer["findings"].append(f"rename {answer['bridge']}: {text}")
    notes = [*gap_notes(case.bridge), *([] if answer["findings"] else ["no findings"])]
    return Answer(answer, printed, notes, warnings=answer["findings"])


@command(bridge)
def modal(case: NamedVariantOptions, out: OptionalOut = None) -> Answer:
    """Compute weight, dead-load forces, periods and participating masses with open gaps.

    T1 is the conditioning period of the bridge: the period of its model with pads at zero skew.

    Example: skewbridge bridge modal --bridge osb2s --skew-deg 30
    """
    from skewbridge.analysis import modal as modes

    variant = case.variant
    result = asdict(modes.modal_properties(variant, case.model))
    modal_result = modes.standing_bridge(variant.bridge)
    if out is not None:
        _write(result["modes"], out, "modal")
    warnings = modes.periods_of_file(variant.bridge, modal_result)
    slug, t1_s = variant.normalised().slug, modes.conditioning_period_s(modal_result)
    answer = {"variant": slug, "t1_s": t1_s, **result}
    return Answer(answer, notes=gap_notes(case.bridge), warnings=warnings)


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeVariantOptions(NamedVariantOptions):
    """Options of a variant that by default has no abutments."""

    abutment: Abutment = "roller"


@command(bridge)
def pushover(
    case: FreeVariantOptions, push: PushOptions, units: Units, max_disp_m: MaxDisp = 0.30
) -> Answer:
    """Push a bridge with forces proportional to mass; write base shear against displacement.

    Example: skewbridge bridge pushover --bridge osb1 --direction y --out push
    """
    from skewbridge.analysis.pushover import push_bridge

    return _pushed(partial(push_bridge, max_disp_m=max_disp_m), case, push, units)


@command(bridge)
def static(
    case: NamedVariantOptions, push: PushOptions, units: Units, max_disp_m: MaxDisp = 0.20
) -> Answer:
    """Push the right deck end against its abutment.

    Direction x pushes into the backfill; an angle of 180 degrees pulls away from it.
    `--abutment all` pushes every abutment model in six directions and draws the curves.

    Example: skewbridge bridge static --abutment all --skew-deg 30 --out push
    """
    from skewbridge.analysis.pushover import push_abutment

    return _pushed(partial(push_abutment, max_disp_m=max_disp_m, steps=400), case, push, units)


def _pushed(
    push_curve: "Callable[..., PushCurve]", case: VariantOptions, push: PushOptions, units: Units
) -> Answer:
    """Push one model, or each model in each direction; exit code 1 if a push stopped early."""
    import pandas as pd

    from skewbridge.report.appearance import shown_in
    from skewbridge.report.bridge_figures import ladder_figure

    is_ladder = case.abutment == "all"
    one_push = [(case.abutment, push.angle_deg)]
    full_model = list(ABUTMENTS)[-1]
    first_variant = (replace(case, abutment=full_model) if is_ladder else case).variant
    tables: list[pd.DataFrame] = []
    pushes: list[dict[str, Any]] = []
    stopped = "a push stopped at last_disp_m: no equilibrium at larger displacements"
    for abutment, toward_deg in product(ABUTMENTS, LADDER_ANGLES_DEG) if is_ladder else one_push:
        case_columns = {"abutment": abutment, "angle_deg": toward_deg}
        variant = replace(first_variant, abutment=abutment) if is_ladder else first_variant
        curve = push_curve(variant, case.model, angle_deg=toward_deg)
        columns = {"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}
        tables.append(pd.DataFrame(case_columns | columns if is_ladder else columns))
        values = {
            "peak_kn": curve.peak_n / KN,
            "initial_stiffness_kn_per_m": curve.initial_stiffness_n_per_m / KN,
            "disp_at_peak_m": curve.disp_at_peak_m,
            "last_disp_m": curve.disp_m[-1],
            "is_complete": curve.is_complete,
        }
        pushes.append(case_columns | values)
        if not curve.is_complete and len(curve.decks_m) > 1:
            deck = max(curve.decks_m, key=lambda name: abs(curve.decks_m[name]))
            stopped += f"; the deck from {deck} had moved farthest, {curve.decks_m[deck]:.3g} m"
    curves = pd.concat(tables, ignore_index=True)
    _write(curves, push.out, "curve")
    if is_ladder:
        title = f"{case.bridge}, skew {case.skew_deg:g} degrees"
        with shown_in(units):
            ladder_figure(curves, title=title).savefig(push.out / "ladder.png", dpi=150)
    answer = {"pushes": pushes} if is_ladder else pushes[0]
    all_complete, notes = all(row["is_complete"] for row in pushes), gap_notes(case.bridge)
    if not all_complete:
        notes.append(stopped)
    exit_code = 0 if all_complete else EXIT_FAILED
    return Answer(answer, notes=notes, exit_code=exit_code)


def _draw_model(variant: Variant, options: ModelOptions, picture: Path, units: Units) -> str:
    """Draw a model as a picture; return its title."""
    from skewbridge.bridge.model import model_geometry
    from skewbridge.report.appearance import shown_in
    from skewbridge.report.bridge_figures import model_figure

    geometry = model_geometry(variant, options)
    with shown_in(units):
        model_figure(geometry).savefig(picture, dpi=150)
    return geometry.title


@command(bridge)
def model(case: NamedVariantOptions, out: Out, units: Units) -> Answer:
    """Draw a model (model.png) and write it as an OpenSeesPy script (model.py).

    Example: skewbridge bridge model --skew-deg 45 --out model45
    """
    from skewbridge.analysis.model_script import model_script

    variant, options = case.variant, case.model
    files = [writable_folder(out) / f"model.{ending}" for ending in ("png", "py")]
    title = _draw_model(variant, options, files[0], units)
    write_text(files[1], model_script(variant, options))
    return Answer({"variant": title, "files": list(map(str, files))}, notes=gap_notes(case.bridge))


@command(bridge)
def column(out: Out, case: NamedBridge, units: Units) -> Answer:
    """Compute moment-curvature and shear strength of a column of each bent under dead load.

    Example: skewbridge bridge column --bridge osb2s --out columns
    """
    from skewbridge.analysis.bridge_check import capacity_rows
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import bent_capacities
    from skewbridge.report.appearance import shown_in
    from skewbridge.report.bridge_figures import column_figure

    data = load_bridge(case.bridge)
    if not data.bents:
        raise InputError(f"bridge {data.name} has no columns")
    rows: list[dict[str, Any]] = []
    for column in bent_capacities(data):
        curve, axial_n = column.curve, column.axial_n
        suffix = f"_bent_{column.bent}" if len(data.bents) > 1 else ""
        suffix += "" if column.direction == "all" else f"_{column.direction}"
        table = {"curvature_per_m": curve.curvature_per_m, "moment_knm": curve.moment_nm / KN}
        _write(table, out, f"moment_curvature{suffix}")
        title = f"{data.title}{',' if suffix else ''}{suffix.replace('_', ' ')}"
        with shown_in(units):
            figure = column_figure(curve, column.shear, axial_n, title=title)
        figure.savefig(out / f"column{suffix}.png", dpi=150)
        (row,) = capacity_rows([column])
        names = ("bent", "direction", "axial_kn")
        names += ("plastic_moment_knm", "plastic_shear_kn", "shear_strength_kn")
        values = {
            "yield_curvature_per_m": curve.yield_curvature_per_m,
            "ultimate_curvature_per_m": curve.ultimate_curvature_per_m,
            "curvature_ductility": curve.ultimate_curvature_per_m / curve.yield_curvature_per_m,
        }
        rows.append({name: row[name] for name in names} | values)
    return Answer(rows[0] if len(rows) == 1 else {"columns": rows})


@command(bridge)
def sdc(
    source: Annotated[Path | None, arg("Output folder of run, or bridge.", "[RUN|BRIDGE]")] = None,
    bridge: Annotated[str | None, opt("Bridge to check, or that of the run.", "NAME|FILE")] = None,
    out: OptionalOut = None,
) -> Answer:
    """Check displacements, P-Delta ratio and seat width against the Caltrans criteria.

    A folder of `run` gives all checks of one analysis, for each corner and inner joint. A bridge
    alone gives the capacities of its bents, with the P-Delta ratio at the displacement capacity.

    Example: skewbridge bridge sdc --bridge osb1
    """
    from skewbridge.analysis import bridge_check
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import bent_capacities
    from skewbridge.files.tables import read_frame, records_of

    table_name, notes, warnings = "checks", list[str](), list[str]()
    if source is None or not source.is_dir():
        if source and bridge not in (None, str(source)):
            raise InputError(_TWO_BRIDGES.format(source, bridge))
        data = load_bridge(bridge or str(source or DEFAULT_BRIDGE))
        table_name, title = "bents", data.title
        rows = bridge_check.capacity_rows(bent_capacities(data))
        warnings = [finding for row in rows for finding in bridge_check.bent_findings(row)]
    else:
        demands, bents, table = (read_frame(source / f"{name}.parquet") for name in _OF_RUN)
        (row,) = records_of(demands)
        variant = Variant.of_row(row)
        if bridge is not None and Path(bridge).stem == variant.bridge_name:
            variant = replace(variant, bridge=bridge)
        elif variant.bridge_name not in _known_bridges():
            problem = f"bridge {variant.bridge_name} is unknown: give its file with --bridge"
            raise InputError(f"{source}: {problem}")
        histories = {str(name): table[name].to_numpy() for name in table}
        title, notes = variant.slug, [*failure_notes(row), *gap_notes(variant.bridge)]
        rows = bridge_check.sdc_rows(variant, row, records_of(bents), histories)
        if any(f"{row['check']}".startswith("joint") for row in rows):
            clause = f"{bridge_check.HINGE_CLAUSE}; check the edition that applies"
            least_in = bridge_check.MINIMUM_HINGE_M / INCH
            notes.append(f"least seat of inner joints: {least_in:.0f} in by {clause}")
    if out is not None:
        _write(rows, out, "sdc")
    return Answer({"title": title, table_name: rows}, notes=notes, warnings=warnings)
