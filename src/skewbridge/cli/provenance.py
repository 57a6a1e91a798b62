"""Command that tells where a result comes from."""

from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, messages
from skewbridge.cli.study import DEFAULT_CONFIG, ConfigOption


@clear_errors
def provenance(
    file: Annotated[Path, typer.Argument(help="Table, figure, page or JSON of a study or run.")],
    *,
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Show where a result comes from; exit 1 if the present sources and config give another."""
    from skewbridge.study.origin import origin_of

    origin = origin_of(file, config)
    rows = [
        {"provenance": name, "of the file": value, "now": _now(origin.now.get(name), value)}
        for name, value in sorted(origin.told.items())
    ]
    answer = {"current": origin.is_current, "provenance": origin.told, "now": origin.now}
    emit(answer | {"differences": origin.differences}, rows, as_json=as_json)
    if not origin.is_current:
        messages.print("not current: the present sources or configuration give another result")
        if "config_digest" in origin.differences:
            messages.print(
                f"compared with {config}; for a study with another one add --config FILE"
            )
        raise typer.Exit(EXIT_FAILED)
    if origin.differences:
        messages.print(f"current: what differs ({', '.join(origin.differences)}) is not used by it")
    else:
        messages.print("current: the present sources and configuration give this result")


def _now(value: str | None, of_file: str) -> str:
    return "" if value is None else "same" if value == of_file else value


COMMANDS: Final = (provenance,)
