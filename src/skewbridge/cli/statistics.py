"""Commands that read a whole table of demands, or the joint models made of it."""

from math import isnan
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, messages
from skewbridge.cli.variant_options import (
    ABUTMENT_CHOICES,
    ABUTMENT_NAMES,
    OutOption,
    bridges_of_the_user,
)
from skewbridge.errors import InputError


@clear_errors
def statistics(
    demands: Annotated[
        Path, typer.Argument(help="Table of demands: .parquet or .csv (docs/columns.md).")
    ],
    out: OutOption,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of limit states.")
    ] = Path("config/limit_states.yaml"),
    im: Annotated[
        str | None,
        typer.Option("--im", metavar="COLUMN", help="Intensity measure, if there are several."),
    ] = None,
    margin: Annotated[
        float | None, typer.Option("--margin", help="Relative change that is negligible: 0.05.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Make every table of results/fragility from any table of demands.

    Needs the columns of the axes, motion_id, status, an intensity measure and demands; names,
    scale and incidence are optional. Limit states whose demand the table lacks are left out.
    """
    from skewbridge.fragility.results import statistics_of

    report = statistics_of(demands, out, limit_states=limit_states, im=im, margin=margin)
    for name in report["left_out"]:
        messages.print(f"left out, the table lacks its demand: {name}", style="yellow")
    for note in report["notes"]:
        messages.print(note, style="yellow")
    emit(report, _counts(report), as_json=as_json, title=str(out))


def _counts(report: dict[str, Any]) -> list[dict[str, Any]]:
    rows = [{"what": f"rows of {name}", "count": n} for name, n in report["tables"].items()]
    for kind in ("status", "verdict"):
        rows += [{"what": f"{kind} {name}", "count": n} for name, n in report[kind].items()]
    return rows


@clear_errors
def predict(
    bridge: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Not needed for a single one.", autocompletion=bridges_of_the_user
        ),
    ] = None,
    abutment: Annotated[
        str | None,
        typer.Option(
            metavar=ABUTMENT_CHOICES,
            help="The only one, or contact-friction.",
            autocompletion=lambda: list(ABUTMENT_NAMES),
        ),
    ] = None,
    skew_deg: Annotated[float | None, typer.Option(help="Skew in degrees.")] = None,
    gap_mm: Annotated[float | None, typer.Option(help="Joint gap in mm.")] = None,
    friction: Annotated[float | None, typer.Option(help="Coefficient of friction.")] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option("--axis", metavar="NAME=VALUE", help="A further axis; repeatable."),
    ] = None,
    component: Annotated[
        str | None, typer.Option(metavar="NAME", help="Only this component.")
    ] = None,
    state: Annotated[
        str | None, typer.Option(metavar="NAME", help="Only this limit state.")
    ] = None,
    at: Annotated[float | None, typer.Option(help="Intensity of the probabilities.")] = None,
    results: Annotated[
        Path, typer.Option(help="Folder of a study, or one that statistics wrote.")
    ] = Path("results"),
    as_json: JsonOption = False,
) -> None:
    """Predict fragility between the variants of a study: medians, dispersions, probabilities.

    From the joint model over skew, gap and friction; outside the box of the study there is none.
    """
    from skewbridge.fragility.predict import Point, predict_states

    values = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}
    given = {name: value for name, value in values.items() if value is not None}
    point = Point(
        bridge=bridge,
        abutment=abutment,
        values=given | _further(axis or []),
        component=component,
        state=state,
        at=at,
    )
    rows = predict_states(results, point)
    shown = [
        {
            "state": f"{row['component']}/{row['state']}",
            "theta": f"{row['theta']:.3g}",
            "interval": "{:.3g}..{:.3g}".format(*row["ci_theta"]),
            "beta": f"{row['beta_total']:.2f}",
            "records": f"{row['beta']:.2f}",
            **({} if at is None else {"P": f"{row['p']:.3f}"}),
            "left out": "" if isnan(row["loo_error"]) else f"{row['loo_error']:.1%}",
        }
        for row in rows
    ]
    messages.print("left out: error of theta where a variant is left out of the model")
    emit({"rows": rows}, shown, as_json=as_json, title=f"theta in {rows[0]['im']}")


def _further(pairs: list[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        try:
            values[name.strip().replace("-", "_")] = float(text)
        except ValueError:
            raise InputError(f"--axis takes NAME=VALUE, got {pair!r}") from None
        if not equals:
            raise InputError(f"--axis takes NAME=VALUE, got {pair!r}")
    return values


COMMANDS: Final = (statistics, predict)
