"""Commands that show a model, judge a run by design criteria, and study a column."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit_json, emit_table, messages
from skewbridge.cli.variant_options import (
    AbutmentOption,
    BridgeOption,
    FrictionOption,
    GapOption,
    SkewOption,
    variant_of,
)
from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder

if TYPE_CHECKING:
    pass

OutOption = Annotated[Path, typer.Option("--out", help="Folder for the results.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("model")(model)
    app.command("sdc")(sdc)
    app.command("column")(column)


@clear_errors
def model(
    out: OutOption,
    bridge: BridgeOption = "osb1",
    abutment: AbutmentOption = "contact-friction",
    skew_deg: SkewOption = 0,
    gap_mm: GapOption = 51,
    friction: FrictionOption = 0.5,
    gap_scale: Annotated[float, typer.Option("--gap-scale", help="Factor on drawn gaps.")] = 20.0,
    as_json: JsonOption = False,
) -> None:
    """Draw a model (model.png, model.html) and write it as a plain OpenSeesPy script."""
    variant = variant_of(bridge, abutment, skew_deg, gap_mm, friction)
    from skewbridge.analysis.model_script import model_script
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.bridge.options import ModelOptions
    from skewbridge.report.model_view import model_figure, model_page

    geometry = model_geometry(variant)
    folder = writable_folder(out)
    model_figure(geometry, gap_scale=gap_scale).savefig(folder / "model.png", dpi=150)
    page = model_page(geometry, gap_scale=gap_scale)
    (folder / "model.html").write_text(page, encoding="utf-8")
    script = model_script(variant, ModelOptions())
    (folder / "model.py").write_text(script, encoding="utf-8")
    files = [str(folder / name) for name in ("model.png", "model.html", "model.py")]
    if as_json:
        emit_json({"variant": geometry.title, "files": files})
    else:
        messages.print(f"{geometry.title}: {', '.join(files)}", markup=False)


@clear_errors
def sdc(
    source: Annotated[
        Path, typer.Argument(metavar="RUN", help="Folder of `run`, or a demands.parquet.")
    ],
    as_json: JsonOption = False,
) -> None:
    """Displacement, P-Delta and seat checks, as in the Caltrans criteria.

    A folder of `run` gives all checks of one analysis, per corner; the demands of a study give
    one row of ratios per variant, for the medians over its motions.
    """
    from skewbridge.provenance.tables import read_frame

    table = read_frame(source if source.is_file() else source / "demands.parquet")
    histories = None if source.is_file() else read_frame(source / "histories.parquet")
    from skewbridge.analysis.sdc import corner_moves_m, sdc_rows, summary_row
    from skewbridge.variant.variant import parse_slug

    if histories is None:
        wanted = ["deck_disp_m", "acute_corner_unseating_m", "unseating_m"]
        medians = table.groupby("variant")[wanted].median()
        rows = [
            summary_row(parse_slug(str(name)), *(float(value) for value in values))
            for name, *values in medians.itertuples()
        ]
        title = f"median of {len(table)} analyses"
    else:
        variant = parse_slug(str(table["variant"].iloc[0]))
        series = {name: histories[name].to_numpy() for name in histories.columns}
        moves = corner_moves_m(variant, series)
        rows = sdc_rows(variant, float(table["deck_disp_m"].iloc[0]), moves)
        title = variant.slug
    if as_json:
        emit_json({"title": title, "checks": rows})
    else:
        emit_table(rows, title=title)


@clear_errors
def column(
    out: OutOption,
    bridge: BridgeOption = "osb1",
    bent: Annotated[int, typer.Option("--bent", help="Number from the left, 1 and up.")] = 1,
    as_json: JsonOption = False,
) -> None:
    """Moment-curvature and shear strength of a bridge's column under dead load."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import section_response, shear_section
    from skewbridge.bridge.dead_load import column_axial_n

    data = load_bridge(bridge)
    if not 1 <= bent <= len(data.bents):
        raise InputError(f"bent must be within 1..{len(data.bents)}, got {bent}")
    import pandas as pd

    from skewbridge.report.static_figures import column_figure

    axial_n = column_axial_n(data, bent - 1)
    curve = section_response(data.column, axial_n)
    height = data.bents[bent - 1].clear_height_m
    span = height if data.base == "pinned" else height / 2
    shear = shear_section(data.column, span, curve)
    table = {"curvature_per_m": curve.curvature_per_m, "moment_knm": curve.moment_nm / 1e3}
    folder = writable_folder(out)
    pd.DataFrame(table).to_parquet(folder / "moment_curvature.parquet", index=False)
    title = f"{data.title}, bent {bent}, {axial_n / 1e3:.0f} kN"
    column_figure(curve, shear, axial_n, title=title).savefig(folder / "column.png", dpi=150)
    summary = {
        "axial_kn": axial_n / 1e3,
        "plastic_moment_knm": curve.plastic_moment_nm / 1e3,
        "yield_curvature_per_m": curve.yield_curvature_per_m,
        "ultimate_curvature_per_m": curve.ultimate_curvature_per_m,
        "curvature_ductility": curve.curvature_ductility,
        "plastic_shear_kn": curve.plastic_moment_nm / span / 1e3,
    }
    if as_json:
        emit_json(summary)
    else:
        emit_table([summary], title=title)
