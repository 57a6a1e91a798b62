"""An analysis of a finished study, found again by its key."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from skewbridge.cli.output import messages
from skewbridge.errors import InputError

if TYPE_CHECKING:
    from skewbridge.study.task import Task

DEFAULT_CONFIG: Final = Path("config/config.yaml")


def task_of_row(key: str, config: Path) -> "Task":
    """Return the analysis behind a row of the demands of a study.

    Args:
        key: Its ``run_key``.
        config: Configuration of the study.

    Raises:
        InputError: No results here, no such row, or the configuration has no such analysis.
    """
    from skewbridge.provenance.tables import read_table
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.keys import run_key
    from skewbridge.study.loading import load_config
    from skewbridge.study.setup import StudySetup

    study = load_config(config, base=DEFAULT_CONFIG)
    folder = StudyFolder(Path(study.results))
    table = folder.demands
    if not table.is_file():
        raise InputError(f"row {key}: there is no {table}; run the study first")
    rows: list[dict[str, Any]] = read_table(table).to_pylist()
    row = next((row for row in rows if row["run_key"] == key), None)
    if row is None:
        raise InputError(f"row {key}: no such run_key in {table} ({len(rows)} rows)")
    sections = study.model_dump(include={"motions", "model", "analysis"})
    setup = StudySetup.from_sections(sections, folder)
    wanted = row["motion_id"], row["scale"], row["incidence_deg"]
    for task in setup.tasks(row["variant"]):
        if (task.motion.motion.motion_id, task.motion.scale, task.incidence_deg) == wanted:
            if run_key(task) != key:
                messages.print("settings or sources have changed since: the result may differ")
            return task
    raise InputError(
        f"row {key}: {config} has no {wanted[0]} x {wanted[1]:g} at {wanted[2]:g} degrees"
    )
