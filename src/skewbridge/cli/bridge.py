"""Commands for single bridges: catalogue, checks, modes, static pushes, columns, drawings."""

from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from skewbridge.cli.options import (
    BridgeOption,
    OutOption,
    SetOption,
    VariantChoice,
    known_bridges,
    model_options,
    takes_variant,
)
from skewbridge.cli.output import (
    Command,
    JsonOption,
    Units,
    UnitsOption,
    emit,
    emit_json,
    emit_table,
    in_units,
    messages,
    new_group,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder
from skewbridge.units import KN
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant, parse_slug

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from skewbridge.analysis.pushover import PushCurve

LADDER_ANGLES_DEG: Final = (0.0, 30.0, 60.0, 90.0, 150.0, 180.0)

DirectionOption = Annotated[
    Literal["x", "y"], typer.Option("--direction", help="x is longitudinal, y transverse.")
]
AngleOption = Annotated[
    float | None,
    typer.Option("--angle-deg", help="Direction counter-clockwise from x; replaces --direction."),
]
MaxDispOption = Annotated[float, typer.Option("--max-disp-m", help="Displacement at the end.")]
OptionalOutOption = Annotated[Path | None, typer.Option("--out", help="Folder for the table.")]

commands = new_group()
bridge = new_group("bridge", "List, check, draw and push single bridges.")
commands.add_typer(bridge)


@bridge.command(name="list", cls=Command)
def list_bridges(*, as_json: JsonOption = False) -> None:
    """List the bridges of the catalogue and those in config/bridges.

    Example: skewbridge bridge list
    """
    from skewbridge.bridge.catalogue import load_bridge

    rows = [
        {
            "bridge": name,
            "title": data.title,
            "length_m": data.length_m,
            "bents": len(data.bents),
            "t1_s": data.t1_s,
        }
        for name, data in ((name, load_bridge(name)) for name in known_bridges())
    ]
    emit({"bridges": rows}, rows, as_json=as_json)


@bridge.command(cls=Command)
def check(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME|FILE]",
            help="Bridge to check, instead of --bridge.",
            autocompletion=known_bridges,
        ),
    ] = None,
    bridge: BridgeOption = "osb1",
    out: Annotated[
        Path | None, typer.Option(help="Folder of model.png; by default results/bridges/NAME.")
    ] = None,
    skew_deg: Annotated[float, typer.Option(help="Skew in the picture.")] = 30,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Check a bridge: keys, weight, axial loads, periods, capacities, picture.

    Everything that would stop or distort a study is reported; exits with 2 if the file is invalid.

    Example: skewbridge bridge check config/bridges/mine.yaml
    """
    from skewbridge.analysis.bridge_check import check_bridge
    from skewbridge.analysis.step_loop import solver_log
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.bridge_figures import model_figure

    chosen = name or bridge
    report = check_bridge(chosen)
    picture = writable_folder(out or Path("results/bridges") / report.bridge.name) / "model.png"
    values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": skew_deg}
    with solver_log(None):
        geometry = model_geometry(Variant.at(chosen, "contact_friction", values), ModelOptions())
    model_figure(geometry).savefig(picture, dpi=150)
    answer = {
        **report.summary(),
        "modes": [asdict(mode) for mode in report.standing.modes],
        "bents": list(report.bents),
        "findings": list(report.findings),
        "picture": str(picture),
    }
    summary = [{"quantity": key, "value": value} for key, value in report.summary().items()]
    emit(answer, summary, as_json=as_json, units=units)
    if not as_json:
        by_quantity = [
            {"of a column": key, **{f"bent {row['bent']}": row[key] for row in report.bents}}
            for key in (report.bents[0] if report.bents else ())
            if key != "bent"
        ]
        emit_table(in_units(by_quantity, units))
    for finding in report.findings:
        messages.print(f"warning: {finding}", style="yellow")
    messages.print(f"{'no findings; ' if not report.findings else ''}picture: {picture}")


@bridge.command(cls=Command)
@takes_variant()
def modal(
    choice: VariantChoice,
    changes: SetOption = None,
    out: OptionalOutOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Compute weight, dead-load forces, periods and participating masses with open gaps.

    T1 is the conditioning period of the bridge: that of its model with pads at zero skew.

    Example: skewbridge bridge modal --bridge osb2s --skew-deg 30
    """
    import pandas as pd

    from skewbridge.analysis.modal import (
        conditioning_period_s,
        modal_properties,
        periods_of_file,
        standing_bridge,
    )
    from skewbridge.analysis.step_loop import solver_log

    variant = choice.variant()
    slug = variant.normalised().slug
    with solver_log(None):
        result = asdict(modal_properties(variant, model_options(changes)))
    standing = standing_bridge(variant.bridge)
    t1_s = conditioning_period_s(standing)
    if out is not None:
        path = writable_folder(out) / "modal.parquet"
        pd.DataFrame(result["modes"]).to_parquet(path, index=False)
    if not as_json:
        forces = {"weight_kn": result["weight_kn"], "axial_kn": list(result["column_axial_kn"])}
        weight, axial = in_units([forces], units)[0].values()
        unit = "kip" if units == "us" else "kN"
        messages.print(
            f"weight {weight:.0f} {unit}; column base axial force "
            f"{', '.join(f'{force:.0f}' for force in axial)} {unit}; T1 {t1_s:.4g} s"
        )
    for warning in periods_of_file(variant.bridge, standing):
        messages.print(f"warning: {warning}", style="yellow")
    answer = {"variant": slug, "t1_s": t1_s, **result}
    emit(answer, result["modes"], as_json=as_json, title=slug)


@bridge.command(cls=Command)
@takes_variant(abutment="roller")
def pushover(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.30,
    changes: SetOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Push the whole bridge in proportion to its masses; base shear against displacement.

    Example: skewbridge bridge pushover --bridge osb1 --direction y --out push
    """
    from skewbridge.analysis.pushover import push_bridge
    from skewbridge.analysis.step_loop import solver_log

    variant, options = choice.variant(), model_options(changes)
    angle = _angle(direction, angle_deg)
    with solver_log(None):
        curve = push_bridge(variant, options, angle_deg=angle, max_disp_m=max_disp_m)
    _finish(curve, out, units, as_json=as_json)


@bridge.command(cls=Command)
@takes_variant()
def static(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.20,
    changes: SetOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Push one abutment at its deck end (x: into the backfill, angle 180: away from it).

    `--abutment all` pushes every abutment model in six directions and draws the curves.

    Example: skewbridge bridge static --abutment all --skew-deg 30 --out push
    """
    from skewbridge.analysis.pushover import push_abutment
    from skewbridge.analysis.step_loop import solver_log

    options = model_options(changes)

    def push(variant: Variant, angle: float) -> "PushCurve":
        with solver_log(None):
            return push_abutment(
                variant, options, angle_deg=angle, max_disp_m=max_disp_m, steps=400
            )

    if choice.abutment == "all":
        _push_all_models(choice, push, out, units, as_json=as_json)
    else:
        curve = push(choice.variant(), _angle(direction, angle_deg))
        _finish(curve, out, units, as_json=as_json)


def _push_all_models(
    choice: VariantChoice,
    push: "Callable[[Variant, float], PushCurve]",
    out: Path,
    units: Units,
    *,
    as_json: bool,
) -> None:
    """Push every abutment model in all directions; write the curves and their figure."""
    import pandas as pd

    from skewbridge.report.bridge_figures import ladder_figure

    variants = {name: choice.variant(name) for name in ABUTMENTS}
    tables: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    for (name, variant), angle in product(variants.items(), LADDER_ANGLES_DEG):
        curve, case = push(variant, angle), {"abutment": name, "angle_deg": angle}
        tables.append(pd.DataFrame(case | _columns(curve)))
        peaks.append(case | {"peak_kn": curve.peak_n / KN})
    curves = pd.concat(tables, ignore_index=True)
    folder = writable_folder(out)
    curves.to_parquet(folder / "curve.parquet", index=False)
    first = next(iter(variants.values()))
    title = (
        f"{first.bridge_name}, right abutment, skew {first.skew_deg} degrees, gap {first.gap_mm} mm"
    )
    ladder_figure(curves, title=title).savefig(folder / "ladder.png", dpi=150)
    emit({"pushes": peaks}, peaks, as_json=as_json, title=title, units=units)


def _angle(direction: Literal["x", "y"], angle_deg: float | None) -> float:
    if angle_deg is not None:
        return angle_deg
    return 0.0 if direction == "x" else 90.0


def _columns(curve: "PushCurve") -> dict[str, Any]:
    return {"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}


def _finish(curve: "PushCurve", out: Path, units: Units, *, as_json: bool) -> None:
    """Write the curve and its summary; exit with an error if the push stopped early."""
    import pandas as pd

    table = pd.DataFrame(_columns(curve))
    table.to_parquet(writable_folder(out) / "curve.parquet", index=False)
    summary = {
        "peak_kn": curve.peak_n / KN,
        "initial_stiffness_kn_per_m": curve.initial_stiffness_n_per_m / KN,
        "disp_at_peak_m": curve.disp_at_peak_m,
        "is_complete": curve.is_complete,
    }
    emit(summary, [summary], as_json=as_json, units=units)
    if not curve.is_complete:
        messages.print(f"the push stopped at {curve.disp_m[-1]:.4f} m: no equilibrium after that")
        raise typer.Exit(EXIT_FAILED)


@bridge.command(cls=Command)
@takes_variant()
def model(
    choice: VariantChoice,
    out: OutOption,
    changes: SetOption = None,
    gap_scale: Annotated[float, typer.Option(help="Factor on the gaps in the drawing.")] = 20.0,
    as_json: JsonOption = False,
) -> None:
    """Draw a model (model.png, model.html) and write it as an OpenSeesPy script (model.py).

    Example: skewbridge bridge model --skew-deg 45 --out model45
    """
    from skewbridge.analysis.model_script import model_script
    from skewbridge.analysis.step_loop import solver_log
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.bridge_figures import model_figure, model_page

    variant, options = choice.variant(), model_options(changes)
    with solver_log(None):
        geometry = model_geometry(variant, options)
    folder = writable_folder(out)
    model_figure(geometry, gap_scale=gap_scale).savefig(folder / "model.png", dpi=150)
    page = model_page(geometry, gap_scale=gap_scale)
    (folder / "model.html").write_text(page, encoding="utf-8")
    with solver_log(None):
        script = model_script(variant, options)
    (folder / "model.py").write_text(script, encoding="utf-8")
    files = [str(folder / name) for name in ("model.png", "model.html", "model.py")]
    if as_json:
        emit_json({"variant": geometry.title, "files": files})
    else:
        messages.print(f"{geometry.title}: {', '.join(files)}")


@bridge.command(cls=Command)
def column(
    out: OutOption,
    bridge: BridgeOption = "osb1",
    bent: Annotated[int, typer.Option(help="Number from the left, 1 and up.")] = 1,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Compute moment-curvature and shear strength of a column under dead load.

    Example: skewbridge bridge column --bridge osb2s --bent 2 --out column
    """
    import pandas as pd

    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import shear_section
    from skewbridge.bridge.gravity import column_axial_n
    from skewbridge.bridge.hinge import shear_span_m
    from skewbridge.bridge.moment_curvature import section_response
    from skewbridge.report.bridge_figures import column_figure

    data = load_bridge(bridge)
    if not 1 <= bent <= len(data.bents):
        raise InputError(f"bent must be within 1..{len(data.bents)}, got {bent}")
    axial_n = column_axial_n(data, bent - 1)
    curve = section_response(data.column, axial_n)
    span = shear_span_m(data, bent - 1)
    shear = shear_section(data.column, span, curve)
    table = {"curvature_per_m": curve.curvature_per_m, "moment_knm": curve.moment_nm / KN}
    folder = writable_folder(out)
    pd.DataFrame(table).to_parquet(folder / "moment_curvature.parquet", index=False)
    title = f"{data.title}, bent {bent}, {axial_n / KN:.0f} kN"
    column_figure(curve, shear, axial_n, title=title).savefig(folder / "column.png", dpi=150)
    summary = {
        "axial_kn": axial_n / KN,
        "plastic_moment_knm": curve.plastic_moment_nm / KN,
        "yield_curvature_per_m": curve.yield_curvature_per_m,
        "ultimate_curvature_per_m": curve.ultimate_curvature_per_m,
        "curvature_ductility": curve.curvature_ductility,
        "plastic_shear_kn": curve.plastic_moment_nm / span / KN,
    }
    emit(summary, [summary], as_json=as_json, title=title, units=units)


@bridge.command(cls=Command)
def sdc(
    source: Annotated[
        Path | None,
        typer.Argument(
            metavar="[RUN|DEMANDS]",
            help="Folder of `skewbridge run`, or a demands.parquet; without it: --bridge alone.",
        ),
    ] = None,
    bridge: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="Bridge; for RUN or DEMANDS only if its name in the table does not find it.",
            autocompletion=known_bridges,
        ),
    ] = None,
    out: OptionalOutOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Check displacement, P-Delta and seat as in the Caltrans criteria.

    A folder of `run` gives all checks of one analysis, per corner; the demands of a study give
    one row of ratios per variant, for the medians over its motions; a bridge alone gives the
    capacities of its bents, with the P-Delta ratio at the displacement capacity.

    Example: skewbridge bridge sdc --bridge osb1
    """
    from skewbridge.files.tables import read_frame

    if source is None or str(source) in known_bridges() or source.suffix in (".yaml", ".yml"):
        answer, rows, title = _sdc_capacities(bridge or str(source or "osb1"))
    elif source.is_file():
        answer, title = _sdc_of_demands(read_frame(source), bridge)
        rows = answer["checks"]
    else:
        answer, title = _sdc_of_run(source, bridge)
        rows = answer["checks"]
    if out is not None:
        import pandas as pd

        pd.DataFrame(rows).to_parquet(writable_folder(out) / "sdc.parquet", index=False)
    emit(answer, rows, as_json=as_json, title=title, units=units)


def _sdc_capacities(bridge: str) -> tuple[dict[str, Any], list[dict[str, Any]], str]:
    """Return the capacities of the bents of a bridge: answer, printed rows, title."""
    from skewbridge.analysis.sdc import capacity_rows
    from skewbridge.bridge.catalogue import load_bridge

    data = load_bridge(bridge)
    rows = capacity_rows(data)
    heads = {
        "bent": "bent",
        "hinge_length_m": "hinge (m)",
        "hinge_length_by": "by",
        "capacity_m": "capacity (m)",
        "p_delta_ratio": "P-Delta there",
        "p_delta_limit": "limit",
        "disp_at_p_delta_limit_m": "met at (m)",
        "ok": "ok",
    }
    printed = [{head: row[name] for name, head in heads.items()} for row in rows]
    return {"title": data.title, "bents": rows}, printed, data.title


def _sdc_of_demands(table: "pd.DataFrame", bridge: str | None) -> tuple[dict[str, Any], str]:
    """Return the ratios of the variants of a study: answer and title."""
    from skewbridge.analysis.sdc import summary_row

    medians = table.groupby("variant")[["deck_disp_m", "acute_corner_unseating_m", "unseating_m"]]
    rows = [
        summary_row(_variant(str(slug), bridge), *map(float, values))
        for slug, *values in medians.median().itertuples()
    ]
    title = f"median of {len(table)} analyses"
    return {"title": title, "checks": rows}, title


def _sdc_of_run(folder: Path, bridge: str | None) -> tuple[dict[str, Any], str]:
    """Return the checks of the analysis in a folder of `skewbridge run`: answer and title."""
    from skewbridge.analysis.sdc import corner_moves_m, sdc_rows
    from skewbridge.files.tables import read_frame

    table = read_frame(folder / "demands.parquet")
    histories = read_frame(folder / "histories.parquet")
    variant = _variant(str(table["variant"].iloc[0]), bridge)
    moves = corner_moves_m(
        variant, {str(name): values.to_numpy() for name, values in histories.items()}
    )
    rows = sdc_rows(variant, float(table["deck_disp_m"].iloc[0]), moves)
    return {"title": variant.slug, "checks": rows}, variant.slug


def _variant(slug: str, bridge: str | None) -> Variant:
    """Return the variant of a name; its bridge may be read from a file of that name."""
    variant = parse_slug(slug)
    if bridge is None or Path(bridge).stem != variant.bridge_name:
        return variant
    return replace(variant, bridge=bridge)
