"""Commands for single bridges: catalogue, checks, modes, static pushes, columns, drawings."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from skewbridge.cli.options import (
    ABUTMENT,
    BRIDGE,
    OUT,
    VARIANT,
    known_bridges,
    model_of,
    variant_of,
)
from skewbridge.cli.output import (
    UNITS,
    Answer,
    Arg,
    Opt,
    Printed,
    command,
    in_units,
    new_group,
    quantities,
    warn,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder, write_text
from skewbridge.units import KN, Units
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant, parse_slug

if TYPE_CHECKING:
    from skewbridge.analysis.pushover import PushCurve

LADDER_ANGLES_DEG: Final = (0.0, 30.0, 60.0, 90.0, 150.0, 180.0)
_OPTIONAL_OUT: Final = Opt("out", Path | None, "Folder for the table.")
_MAX_DISP: Final = Opt("max_disp_m", float, "Final displacement of the push, in m.", 0.20)
_PUSH: Final = (
    *VARIANT,
    OUT,
    Opt("direction", Literal["x", "y"], "Direction of the push: x longitudinal, y transverse.",
        "x"),
    Opt("angle_deg", float | None, "Direction counter-clockwise from x; replaces --direction."),
    _MAX_DISP,
    UNITS,
)  # fmt: skip

#: Printed columns of the capacities of a bent, with their heads.
_CAPACITIES: Final = {
    "bent": "bent",
    "hinge_length_m": "hinge (m)",
    "hinge_length_by": "by",
    "capacity_m": "capacity (m)",
    "p_delta_ratio": "P-Delta there",
    "p_delta_limit": "limit",
    "disp_at_p_delta_limit_m": "met at (m)",
    "ok": "ok",
}

commands = new_group()
bridge = new_group("bridge", "List, check, draw and push single bridges.")
commands.add_typer(bridge)


def _without_messages[T](function: Callable[..., T], *given: Any, **named: Any) -> T:
    """Return the result of a function whose solver writes its messages nowhere."""
    from skewbridge.analysis.step_loop import solver_log

    with solver_log(None):
        return function(*given, **named)


def _write(columns: Any, folder: Path, name: str) -> None:
    """Write a table as Parquet."""
    import pandas as pd

    pd.DataFrame(columns).to_parquet(writable_folder(folder) / f"{name}.parquet", index=False)


@command(bridge, name="list")
def list_bridges() -> Answer:
    """List the bridges of the catalogue and those in config/bridges.

    Example: skewbridge bridge list
    """
    from skewbridge.bridge.catalogue import load_bridge

    found = {name: load_bridge(name) for name in known_bridges()}
    rows = [
        {"bridge": name, "title": data.title, "length_m": data.length_m, "bents": len(data.bents),
         "t1_s": data.t1_s}
        for name, data in found.items()
    ]  # fmt: skip
    return Answer({"bridges": rows}, [Printed(rows)])


@command(
    bridge,
    Arg("name", str | None, "Bridge to check, instead of --bridge.", None, "[NAME|FILE]",
        known_bridges),
    BRIDGE,
    Opt("out", Path | None, "Folder of model.png; by default results/bridges/NAME."),
    Opt("skew_deg", float, "Skew in the picture.", 30),
    UNITS,
)  # fmt: skip
def check(name: str | None, bridge: str, out: Path | None, skew_deg: float, units: Units) -> Answer:
    """Check a bridge: keys, weight, axial loads, periods, capacities, picture.

    Everything that would stop or distort a study is reported; exits with 2 if the file is invalid.

    Example: skewbridge bridge check config/bridges/mine.yaml
    """
    from skewbridge.analysis.bridge_check import check_bridge
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.bridge_figures import model_figure

    report = check_bridge(name or bridge)
    picture = writable_folder(out or Path("results/bridges") / report.bridge.name) / "model.png"
    values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": skew_deg}
    variant = Variant.at(name or bridge, "contact_friction", values)
    geometry = _without_messages(model_geometry, variant, ModelOptions())
    model_figure(geometry).savefig(picture, dpi=150)
    lists = {
        "modes": [asdict(mode) for mode in report.standing.modes],
        "bents": report.bents,
        "findings": report.findings,
    }
    columns = [
        {"of a column": key, **{f"bent {row['bent']}": row[key] for row in report.bents}}
        for key in (report.bents[0] if report.bents else ())
        if key != "bent"
    ]
    for finding in report.findings:
        warn(finding)
    return Answer(
        {**report.summary(), **lists, "picture": str(picture)},
        [Printed(quantities(report.summary())), Printed(columns)],
        units,
        [f"{'' if report.findings else 'no findings; '}picture: {picture}"],
    )


@command(bridge, *VARIANT, _OPTIONAL_OUT, UNITS)
def modal(out: Path | None, units: Units, **given: Any) -> Answer:
    """Compute weight, dead-load forces, periods and participating masses with open gaps.

    T1 is the conditioning period of the bridge: that of its model with pads at zero skew.

    Example: skewbridge bridge modal --bridge osb2s --skew-deg 30
    """
    from skewbridge.analysis.modal import (
        conditioning_period_s,
        modal_properties,
        periods_of_file,
        standing_bridge,
    )

    variant = variant_of(given)
    slug = variant.normalised().slug
    result = asdict(_without_messages(modal_properties, variant, model_of(given)))
    standing = standing_bridge(variant.bridge)
    t1_s = conditioning_period_s(standing)
    if out is not None:
        _write(result["modes"], out, "modal")
    forces = {"weight_kn": result["weight_kn"], "axial_kn": list(result["column_axial_kn"])}
    weight, axial = in_units([forces], units)[0].values()
    unit = "kip" if units == "us" else "kN"
    listed = ", ".join(f"{force:.0f}" for force in axial)
    note = (
        f"weight {weight:.0f} {unit}; column base axial force {listed} {unit}; "
        f"conditioning period T1 {t1_s:.4g} s"
    )
    for warning in periods_of_file(variant.bridge, standing):
        warn(warning)
    answer = {"variant": slug, "t1_s": t1_s, **result}
    return Answer(answer, [Printed(result["modes"], slug)], notes=[note])


@command(bridge, *_PUSH, ABUTMENT._replace(default="roller"), _MAX_DISP._replace(default=0.30))
def pushover(**given: Any) -> Answer:
    """Push the whole bridge in proportion to its masses; base shear against displacement.

    Example: skewbridge bridge pushover --bridge osb1 --direction y --out push
    """
    from skewbridge.analysis.pushover import push_bridge

    return _pushed(partial(push_bridge, max_disp_m=given["max_disp_m"]), given)


@command(bridge, *_PUSH)
def static(**given: Any) -> Answer:
    """Push one abutment at its deck end (x: into the backfill, angle 180: away from it).

    `--abutment all` pushes every abutment model in six directions and draws the curves.

    Example: skewbridge bridge static --abutment all --skew-deg 30 --out push
    """
    from skewbridge.analysis.pushover import push_abutment

    push = partial(push_abutment, max_disp_m=given["max_disp_m"], steps=400)
    return (_pushed_ladder if given["abutment"] == "all" else _pushed)(push, given)


def _pushed(push: "Callable[..., PushCurve]", given: Mapping[str, Any]) -> Answer:
    """Push once and write the curve; the command fails if the push stopped early."""
    angle_deg = given["angle_deg"]
    if angle_deg is None:
        angle_deg = {"x": 0.0, "y": 90.0}[given["direction"]]
    curve = _without_messages(push, variant_of(given), model_of(given), angle_deg=angle_deg)
    _write({"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}, given["out"], "curve")
    summary = {
        "peak_kn": curve.peak_n / KN,
        "initial_stiffness_kn_per_m": curve.initial_stiffness_n_per_m / KN,
        "disp_at_peak_m": curve.disp_at_peak_m,
        "is_complete": curve.is_complete,
    }
    answer = Answer(summary, [Printed([summary])], given["units"])
    if curve.is_complete:
        return answer
    note = f"the push stopped at {curve.disp_m[-1]:.4f} m: no equilibrium after that"
    return replace(answer, notes=[note], exit_code=EXIT_FAILED)


def _pushed_ladder(push: "Callable[..., PushCurve]", given: Mapping[str, Any]) -> Answer:
    """Push every abutment model in all directions; write the curves and their figure."""
    import pandas as pd

    from skewbridge.report.bridge_figures import ladder_figure

    folder = writable_folder(given["out"])
    tables: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    for abutment, angle_deg in product(ABUTMENTS, LADDER_ANGLES_DEG):
        case, variant = {"abutment": abutment, "angle_deg": angle_deg}, variant_of(given, abutment)
        curve = _without_messages(push, variant, model_of(given), angle_deg=angle_deg)
        columns = {"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}
        tables.append(pd.DataFrame(case | columns))
        peaks.append(case | {"peak_kn": curve.peak_n / KN})
    curves = pd.concat(tables, ignore_index=True)
    _write(curves, folder, "curve")
    title = (
        f"{variant_of(given, 'roller').bridge_name}, right abutment, skew {given['skew_deg']:g} "
        f"degrees, gap {given['gap_mm']:g} mm"
    )
    ladder_figure(curves, title=title).savefig(folder / "ladder.png", dpi=150)
    return Answer({"pushes": peaks}, [Printed(peaks, title)], given["units"])


@command(
    bridge,
    *VARIANT,
    OUT,
    Opt("gap_scale", float, "Magnification of the gaps in the drawing.", 20.0),
)
def model(out: Path, gap_scale: float, **given: Any) -> Answer:
    """Draw a model (model.png, model.html) and write it as an OpenSeesPy script (model.py).

    Example: skewbridge bridge model --skew-deg 45 --out model45
    """
    from skewbridge.analysis.model_script import model_script
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.bridge_figures import model_figure, model_page

    variant, options = variant_of(given), model_of(given)
    geometry = _without_messages(model_geometry, variant, options)
    script = _without_messages(model_script, variant, options)
    picture, page, code = (
        writable_folder(out) / f"model.{ending}" for ending in ("png", "html", "py")
    )
    model_figure(geometry, gap_scale=gap_scale).savefig(picture, dpi=150)
    write_text(page, model_page(geometry, gap_scale=gap_scale))
    write_text(code, script)
    files = [str(picture), str(page), str(code)]
    note = f"{geometry.title}: {', '.join(files)}"
    return Answer({"variant": geometry.title, "files": files}, [], notes=[note])


@command(bridge, BRIDGE, OUT, Opt("bent", int, "Number from the left, 1 and up.", 1), UNITS)
def column(bridge: str, out: Path, bent: int, units: Units) -> Answer:
    """Compute moment-curvature and shear strength of a column under dead load.

    Example: skewbridge bridge column --bridge osb2s --bent 2 --out column
    """
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import shear_section
    from skewbridge.bridge.gravity import column_axial_n
    from skewbridge.bridge.hinge import shear_span_m
    from skewbridge.bridge.moment_curvature import section_response
    from skewbridge.report.bridge_figures import column_figure

    data = load_bridge(bridge)
    if not 1 <= bent <= len(data.bents):
        raise InputError(f"bent must be within 1..{len(data.bents)}, got {bent}")
    axial_n, span = column_axial_n(data, bent - 1), shear_span_m(data, bent - 1)
    curve = section_response(data.column, axial_n)
    shear = shear_section(data.column, span, curve)
    table = {"curvature_per_m": curve.curvature_per_m, "moment_knm": curve.moment_nm / KN}
    _write(table, out, "moment_curvature")
    title = f"{data.title}, bent {bent}, {axial_n / KN:.0f} kN"
    column_figure(curve, shear, axial_n, title=title).savefig(out / "column.png", dpi=150)
    summary = {
        "axial_kn": axial_n / KN,
        "plastic_moment_knm": curve.plastic_moment_nm / KN,
        "yield_curvature_per_m": curve.yield_curvature_per_m,
        "ultimate_curvature_per_m": curve.ultimate_curvature_per_m,
        "curvature_ductility": curve.curvature_ductility,
        "plastic_shear_kn": curve.plastic_moment_nm / span / KN,
    }
    return Answer(summary, [Printed([summary], title)], units)


@command(
    bridge,
    Arg("source", Path | None,
        "Folder of `skewbridge run`, or a demands.parquet; without it: --bridge alone.", None,
        "[RUN|DEMANDS]"),
    BRIDGE._replace(
        kind=str | None, default=None,
        help="Bridge; RUN or DEMANDS need it only if the name in the table is unknown.",
    ),
    _OPTIONAL_OUT,
    UNITS,
)  # fmt: skip
def sdc(source: Path | None, bridge: str | None, out: Path | None, units: Units) -> Answer:
    """Check displacement, P-Delta and seat as in the Caltrans criteria.

    A folder of `run` gives all checks of one analysis, per corner; the demands of a study give
    one row of ratios per variant, for the medians over its motions; a bridge alone gives the
    capacities of its bents, with the P-Delta ratio at the displacement capacity.

    Example: skewbridge bridge sdc --bridge osb1
    """
    from skewbridge.analysis.sdc import capacity_rows
    from skewbridge.bridge.catalogue import load_bridge

    if source is None or str(source) in known_bridges() or source.suffix in (".yaml", ".yml"):
        data = load_bridge(bridge or str(source or "osb1"))
        title, bents = data.title, capacity_rows(data)
        rows = [{head: row[name] for name, head in _CAPACITIES.items()} for row in bents]
        answer = {"title": title, "bents": bents}
    else:
        title, rows = (_sdc_of_demands if source.is_file() else _sdc_of_run)(source, bridge)
        answer = {"title": title, "checks": rows}
    if out is not None:
        _write(rows, out, "sdc")
    return Answer(answer, [Printed(rows, title)], units)


def _sdc_of_demands(path: Path, bridge: str | None) -> tuple[str, list[dict[str, object]]]:
    """Return the ratios of the variants of a study, with a title."""
    from skewbridge.analysis.sdc import summary_row
    from skewbridge.files.tables import read_frame

    table = read_frame(path)
    names = ["deck_disp_m", "acute_corner_unseating_m", "unseating_m"]
    medians = table.groupby("variant")[names].median().itertuples()
    rows = [summary_row(_variant(str(name), bridge), *map(float, own)) for name, *own in medians]
    return f"median of {len(table)} analyses", rows


def _sdc_of_run(folder: Path, bridge: str | None) -> tuple[str, list[dict[str, object]]]:
    """Return the checks of the analysis in a folder of `skewbridge run`, with a title."""
    from skewbridge.analysis.sdc import corner_moves_m, sdc_rows
    from skewbridge.files.tables import read_frame

    row = read_frame(folder / "demands.parquet").iloc[0]
    table = read_frame(folder / "histories.parquet")
    variant = _variant(str(row["variant"]), bridge)
    moves = corner_moves_m(variant, {str(name): table[name].to_numpy() for name in table})
    return variant.slug, sdc_rows(variant, float(row["deck_disp_m"]), moves)


def _variant(slug: str, bridge: str | None) -> Variant:
    """Return the variant of a name; its bridge may be read from a file of that name."""
    variant = parse_slug(slug)
    if bridge is None or Path(bridge).stem != variant.bridge_name:
        return variant
    return replace(variant, bridge=bridge)
