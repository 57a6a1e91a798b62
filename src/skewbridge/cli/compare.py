"""`skewbridge compare`: what differs between two studies."""

from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit_json, emit_table, messages
from skewbridge.errors import InputError

StudyArgument = Annotated[
    Path, typer.Argument(help="Folder of a study, or its table of demands (.parquet, .csv).")
]


@clear_errors
def compare(
    first: StudyArgument,
    second: StudyArgument,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of the limit states of the medians.")
    ] = Path("config/limit_states.yaml"),
    im: Annotated[
        str, typer.Option("--im", metavar="COLUMN", help="Intensity of the medians.")
    ] = "im_saavg_rotd50_g",
    margin: Annotated[
        float, typer.Option("--margin", help="Relative change that is negligible.")
    ] = 0.05,
    out: Annotated[
        Path | None, typer.Option("--out", help="CSV file for all rows, those of variants too.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare two studies run by run: ratios of demands and medians, the second over the first.

    Runs are paired where bridge, abutment model, all axes, motion, scale and incidence agree.
    """
    from skewbridge.fragility.exports import write_csv
    from skewbridge.study.two_studies import Judgement, compare_studies

    if out is not None and out.suffix != ".csv":
        raise InputError(f"--out must end with .csv, got {out.name}")
    judgement = Judgement(limit_states=limit_states, im=im, margin=margin)
    found = compare_studies(first, second, judgement)
    pair = found.comparison
    if out is not None:
        import pandas as pd

        write_csv(pd.concat([pair.demands, pair.medians], ignore_index=True), out)
    medians = pair.medians[pair.medians["scope"] == "pooled"].to_dict("records")
    if as_json:
        emit_json(
            {
                "counts": pair.counts,
                "other_motions": list(found.other_motions),
                "demands": pair.demands.to_dict("records"),
                "medians": pair.medians.to_dict("records"),
                "medians_by_state": medians,
            }
        )
        return
    pooled = pair.demands[pair.demands["scope"] == "pooled"].to_dict("records")
    emit_table([_shown(row) for row in pooled], f"Demands, {second} over {first}")
    emit_table([_shown(row) for row in medians], f"Median capacities ({im}), {second} over {first}")
    for told in _notes(pair.counts, found.other_motions):
        messages.print(told)


def _shown(row: dict[Any, Any]) -> dict[str, str]:
    by_difference = row["judged_by"] == "difference"
    value, low, high = (
        (row[name] for name in ("difference", "difference_low", "difference_high"))
        if by_difference
        else (row[name] for name in ("ratio", "ci_low", "ci_high"))
    )
    shown = _signed if by_difference else "{:.3f}".format
    told, interval = f"{shown(value)} {row['unit']}".strip(), f"{shown(low)}..{shown(high)}"
    return {
        "bridge": f"{row['bridge']} {row['abutment']}".replace("_", "-"),
        "demand": row["demand"],
        "change": told,
        f"{row['level']:.0%} interval": interval,
        "verdict": row["verdict_family"],
        "motions": str(row["n_motions"]),
        "pairs": str(row["n_pairs"]),
    }


def _signed(value: float) -> str:
    return f"{value:+.3g}" if value else "0"


def _notes(counts: dict[str, int], other_motions: tuple[str, ...]) -> list[str]:
    told = [
        "{pairs} pairs of {variants} variants and {motions} motions; {only_first} runs of the "
        "first and {only_second} of the second study have no partner".format(**counts)
    ]
    if counts["equal_pairs"]:
        told.append(f"{counts['equal_pairs']} pairs have the same demands to the last digit")
    if other_motions:
        shown = ", ".join(other_motions[:5])
        told.append(
            f"warning: {len(other_motions)} motions have one name in both studies but other "
            f"files, and are left out: {shown}"
        )
    return told


COMMANDS: Final = (compare,)
