"""`skewbridge init`: the folder of a new study."""

from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, messages


@clear_errors
def init(
    folder: Annotated[Path, typer.Argument(help="Folder of the study; made if there is none.")],
    *,
    as_json: JsonOption = False,
) -> None:
    """Write Snakefile, rules, configuration and motions of a study into a folder."""
    from skewbridge.study.starter import write_starter

    written = [str(path) for path in write_starter(folder)]
    emit({"written": written}, [{"written": path} for path in written], as_json=as_json)
    messages.print(
        f"cd {folder}, then: snakemake -j2 --configfile config/smoke.yaml (a small study) or "
        "snakemake -j2 (the default study; skewbridge plan shows its cost)"
    )


COMMANDS: Final = (init,)
