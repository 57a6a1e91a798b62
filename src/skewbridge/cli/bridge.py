"""Commands of the bridge package: models, modes, static pushes, design checks, columns."""

from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, emit_json, messages
from skewbridge.cli.variant_options import (
    BridgeOption,
    OutOption,
    SetOption,
    VariantChoice,
    model_options,
    takes_variant,
)
from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder
from skewbridge.units import KN
from skewbridge.variant.abutments import ABUTMENTS

if TYPE_CHECKING:
    from skewbridge.analysis.pushover import PushCurve
    from skewbridge.variant.options import ModelOptions

LADDER_ANGLES_DEG = (0.0, 30.0, 60.0, 90.0, 150.0, 180.0)

DirectionOption = Annotated[
    str, typer.Option("--direction", help="x (longitudinal) or y (transverse).")
]
AngleOption = Annotated[
    float | None,
    typer.Option("--angle-deg", help="Direction counter-clockwise from x; replaces --direction."),
]
MaxDispOption = Annotated[float, typer.Option("--max-disp-m", help="Where the push ends.")]


@clear_errors
@takes_variant()
def modal(
    choice: VariantChoice,
    changes: SetOption = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for modal.parquet.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Weight, dead-load forces, periods and participating masses, gaps open."""
    variant, options = choice.variant(), model_options(changes)
    import pandas as pd

    from skewbridge.analysis.modal import modal_properties

    slug = variant.normalised().slug
    result = asdict(modal_properties(variant, options))
    modes = result["modes"]
    if out is not None:
        pd.DataFrame(modes).to_parquet(writable_folder(out) / "modal.parquet", index=False)
    if not as_json:
        axial = ", ".join(f"{force:.0f}" for force in result["column_axial_kn"])
        weight = f"weight {result['weight_kn']:.0f} kN"
        messages.print(f"{weight}; column base axial force {axial} kN")
    emit({"variant": slug, **result}, modes, as_json=as_json, title=slug)


@clear_errors
@takes_variant(abutment="roller")
def pushover(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.30,
    changes: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Push the whole bridge in proportion to its masses; base shear against displacement."""
    variant, options = choice.variant(), model_options(changes)
    angle = _angle(direction, angle_deg)
    from skewbridge.analysis.pushover import push_bridge

    curve = push_bridge(variant, options, angle_deg=angle, max_disp_m=max_disp_m)
    _finish(curve, out, as_json=as_json)


@clear_errors
@takes_variant()
def static(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.20,
    changes: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Push one abutment by its deck end (x: into the backfill, angle 180: away from it).

    `--abutment all` pushes every model of the ladder in six directions and draws them.
    """
    angle = _angle(direction, angle_deg)
    options = model_options(changes)
    if choice.abutment == "all":
        _push_ladder(choice, options, max_disp_m, out, as_json=as_json)
        return
    from skewbridge.analysis.pushover import push_abutment

    curve = push_abutment(
        choice.variant(), options, angle_deg=angle, max_disp_m=max_disp_m, steps=400
    )
    _finish(curve, out, as_json=as_json)


def _push_ladder(
    choice: VariantChoice, options: "ModelOptions", max_disp_m: float, out: Path, *, as_json: bool
) -> None:
    """Push every model of the ladder in all directions; write the curves and their figure."""
    variants = {name: choice.variant(name) for name in ABUTMENTS}
    import pandas as pd

    from skewbridge.analysis.pushover import push_abutment
    from skewbridge.report.static_figures import ladder_figure

    parts: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    for (name, variant), angle in product(variants.items(), LADDER_ANGLES_DEG):
        curve = push_abutment(variant, options, angle_deg=angle, max_disp_m=max_disp_m, steps=400)
        place = {"abutment": name, "angle_deg": angle}
        parts.append(pd.DataFrame(place | _columns(curve)))
        peaks.append(place | {"peak_kn": curve.peak_n / KN})
    curves = pd.concat(parts, ignore_index=True)
    folder = writable_folder(out)
    curves.to_parquet(folder / "curve.parquet", index=False)
    first = next(iter(variants.values()))
    title = (
        f"{first.bridge_name}, right abutment, skew {first.skew_deg} degrees, gap {first.gap_mm} mm"
    )
    ladder_figure(curves, title=title).savefig(folder / "ladder.png", dpi=150)
    emit({"pushes": peaks}, peaks, as_json=as_json, title=title)


def _angle(direction: str, angle_deg: float | None) -> float:
    if angle_deg is not None:
        return angle_deg
    if direction not in ("x", "y"):
        raise InputError(f"direction must be x or y, got {direction!r}")
    return 0.0 if direction == "x" else 90.0


def _columns(curve: "PushCurve") -> dict[str, Any]:
    return {"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}


def _finish(curve: "PushCurve", out: Path, *, as_json: bool) -> None:
    """Write the curve and its summary; a push that stopped early ends with an error code."""
    import pandas as pd

    table = pd.DataFrame(_columns(curve))
    table.to_parquet(writable_folder(out) / "curve.parquet", index=False)
    summary = {
        "peak_kn": curve.peak_n / KN,
        "initial_stiffness_kn_per_m": curve.initial_stiffness_n_per_m / KN,
        "disp_at_peak_m": curve.disp_at_peak_m,
        "is_complete": curve.is_complete,
    }
    emit(summary, [summary], as_json=as_json)
    if not curve.is_complete:
        messages.print(f"the push stopped at {curve.disp_m[-1]:.4f} m: no equilibrium beyond")
        raise typer.Exit(EXIT_FAILED)


@clear_errors
@takes_variant()
def model(
    choice: VariantChoice,
    out: OutOption,
    changes: SetOption = None,
    gap_scale: Annotated[float, typer.Option("--gap-scale", help="Factor on drawn gaps.")] = 20.0,
    as_json: JsonOption = False,
) -> None:
    """Draw a model (model.png, model.html) and write it as a plain OpenSeesPy script."""
    variant, options = choice.variant(), model_options(changes)
    from skewbridge.analysis.model_script import model_script
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.model_view import model_figure, model_page

    geometry = model_geometry(variant, options)
    folder = writable_folder(out)
    model_figure(geometry, gap_scale=gap_scale).savefig(folder / "model.png", dpi=150)
    page = model_page(geometry, gap_scale=gap_scale)
    (folder / "model.html").write_text(page, encoding="utf-8")
    script = model_script(variant, options)
    (folder / "model.py").write_text(script, encoding="utf-8")
    files = [str(folder / name) for name in ("model.png", "model.html", "model.py")]
    if as_json:
        emit_json({"variant": geometry.title, "files": files})
    else:
        messages.print(f"{geometry.title}: {', '.join(files)}", markup=False)


@clear_errors
def sdc(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="RUN|BRIDGE",
            help="Folder of `run`, a demands.parquet, or a bridge: its name or the path of its "
            "file.",
        ),
    ],
    bridge_path: Annotated[
        Path | None,
        typer.Option("--bridge", help="File of the analysed bridge, if its name does not find it."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Displacement, P-Delta and seat checks, as in the Caltrans criteria.

    A folder of `run` gives all checks of one analysis, per corner; the demands of a study give
    one row of ratios per variant, for the medians over its motions. A bridge gives the capacities
    of its bents, with the P-Delta ratio at the displacement capacity.
    """
    from dataclasses import replace

    from skewbridge.analysis.sdc import capacity_rows, corner_moves_m, sdc_rows, summary_row
    from skewbridge.bridge.catalogue import bridge_names, load_bridge
    from skewbridge.bridge.catalogue.loading import OWN_FOLDER
    from skewbridge.provenance.tables import read_frame
    from skewbridge.variant.variant import Variant, parse_slug

    is_named = str(source) in bridge_names() or (OWN_FOLDER / f"{source}.yaml").is_file()
    if is_named or source.suffix in (".yaml", ".yml"):
        data = load_bridge(str(source))
        rows = capacity_rows(data)
        shown = [
            {
                "bent": row["bent"],
                "hinge (m)": row["hinge_length_m"],
                "by": row["hinge_length_by"],
                "capacity (m)": row["capacity_m"],
                "P-Delta there": row["p_delta_ratio"],
                "limit": row["p_delta_limit"],
                "met at (m)": row["disp_at_p_delta_limit_m"],
                "ok": row["ok"],
            }
            for row in rows
        ]
        emit({"title": data.title, "bents": rows}, shown, as_json=as_json, title=data.title)
        return

    def variant_of(slug: str) -> Variant:
        variant = parse_slug(slug)
        if bridge_path is None or bridge_path.stem != variant.bridge_name:
            return variant
        return replace(variant, bridge=str(bridge_path))

    table = read_frame(source if source.is_file() else source / "demands.parquet")
    if source.is_file():
        wanted = ["deck_disp_m", "acute_corner_unseating_m", "unseating_m"]
        medians = table.groupby("variant")[wanted].median()
        rows = [
            summary_row(variant_of(str(name)), *map(float, values))
            for name, *values in medians.itertuples()
        ]
        title = f"median of {len(table)} analyses"
    else:
        histories = read_frame(source / "histories.parquet")
        variant = variant_of(str(table["variant"].iloc[0]))
        series = {name: histories[name].to_numpy() for name in histories.columns}
        moves = corner_moves_m(variant, series)
        rows = sdc_rows(variant, float(table["deck_disp_m"].iloc[0]), moves)
        title = variant.slug
    emit({"title": title, "checks": rows}, rows, as_json=as_json, title=title)


@clear_errors
def column(
    out: OutOption,
    bridge: BridgeOption = "osb1",
    bent: Annotated[int, typer.Option("--bent", help="Number from the left, 1 and up.")] = 1,
    as_json: JsonOption = False,
) -> None:
    """Moment-curvature and shear strength of a bridge's column under dead load."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import shear_section
    from skewbridge.bridge.dead_load import column_axial_n
    from skewbridge.bridge.hinge import shear_span_m
    from skewbridge.bridge.moment_curvature import section_response

    data = load_bridge(bridge)
    if not 1 <= bent <= len(data.bents):
        raise InputError(f"bent must be within 1..{len(data.bents)}, got {bent}")
    import pandas as pd

    from skewbridge.report.static_figures import column_figure

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
    emit(summary, [summary], as_json=as_json, title=title)


COMMANDS: Final = (modal, pushover, static, model, sdc, column)
