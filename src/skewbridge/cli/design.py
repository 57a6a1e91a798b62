"""Commands that judge a bridge by the design criteria: checks of capacities, column sections."""

from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit
from skewbridge.cli.us_units import UnitsOption
from skewbridge.cli.variant_options import BridgeOption, OutOption
from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder
from skewbridge.units import KN


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
    units: UnitsOption = "si",
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
        emit(
            {"title": data.title, "bents": rows},
            shown,
            as_json=as_json,
            title=data.title,
            units=units,
        )
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
    emit({"title": title, "checks": rows}, rows, as_json=as_json, title=title, units=units)


@clear_errors
def column(
    out: OutOption,
    bridge: BridgeOption = "osb1",
    bent: Annotated[int, typer.Option("--bent", help="Number from the left, 1 and up.")] = 1,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Moment-curvature and shear strength of a bridge's column under dead load."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.bridge.column import shear_section
    from skewbridge.bridge.gravity import column_axial_n
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
    emit(summary, [summary], as_json=as_json, title=title, units=units)


COMMANDS: Final = (sdc, column)
