# Shared by all rules: the validated configuration, its variants, and digests of the sources.
import os
import time
from itertools import count

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.files.text import read_mapping
from skewbridge.motions.levels import has_pilot
from skewbridge.study.config import parse_config, store_configuration
from skewbridge.study.folder import StudyFolder, limit_of_round, tables_of_round
from skewbridge.study.inputs import check_inputs
from skewbridge.study.jobs import made_from
from skewbridge.study.processes import CLOCK, PROCESSORS, hold_tree
from skewbridge.variant.grid import expand_grid

RESUME = "Finished jobs and analyses are kept: run the same command to resume."
CONFIG_AS_READ = {path: Path(path).read_bytes() for path in workflow.configfiles}

try:
    # Snakemake has read the files already, but it accepts duplicate keys and keeps the last.
    for path in workflow.configfiles:
        read_mapping(Path(path))
    STUDY = parse_config(config, workflow.overwrite_configfiles)
    FOLDER = StudyFolder(writable_folder(Path(STUDY.results)))
    check_inputs(STUDY, FOLDER.motions_digest)
    VARIANTS = sorted(variant.slug for variant in expand_grid(STUDY.grid))
    # Digests of sources, configuration and inputs by rule, for `params`. Together with the contents
    # of files they decide which rules run again.
    MADE_FROM = made_from(STUDY)
except InputError as error:
    sys.exit(f"error: {error}")  # an exception would be shown with lines of this file

# Commands without analyses, such as `snakemake --unlock` or `--report`, need no --cores.
CORES = workflow.resource_settings.cores or 1
# Parallel variants use the processors better than one variant with parallel motions; a study of
# fewer variants than processors divides the processors among its variants.
ANALYSIS_THREADS = max(1, CORES // len(VARIANTS))

# Additional inputs of a study that runs until its effects are decided (design.until).
ROUNDS = {}

if STUDY.design.until:
    ROUNDS = {"rounds": FOLDER.rounds}
    # For all jobs of this command: its start time and number of processors.
    os.environ.setdefault(CLOCK, f"{time.time():.0f} {CORES}")


wildcard_constraints:
    variant=r"[^/]+",
    round=r"[0-9]+",


def results_folder(wildcards):
    """Return the folder of the study, for `params`."""
    return STUDY.results


def by_attempt(amount):
    """Return a resource that grows with every attempt, for jobs stopped by a cluster."""
    return lambda wildcards, attempt: amount * attempt


def plans_before(number=None):
    """Yield the plans of the rounds before a given number, or of all rounds."""
    for each in count(1):
        if each == number:
            return
        plan = Path(checkpoints.plan_round.get(round=each).output.plan)
        yield plan
        if not tables_of_round(FOLDER, plan):
            return


def demands_of_rounds(wildcards):
    """Return the demands files of the rounds before that of a job, or of all rounds, by name."""
    number = int(wildcards.round) if "round" in wildcards.keys() else None
    paths = [
        path for plan in plans_before(number) for path in tables_of_round(FOLDER, plan)
    ]
    return sorted(paths, key=lambda path: path.name)


def hours_of_round(wildcards):
    """Return the time limit that a round's plan depends on, for `params`."""
    return limit_of_round(FOLDER.round(wildcards.round), STUDY.design.hours)


def edited_meanwhile():
    """Return the configuration files that were edited after this run had read them."""
    return [
        str(path)
        for path, text in CONFIG_AS_READ.items()
        if not Path(path).is_file() or Path(path).read_bytes() != text
    ]


onstart:
    # Only one study may run in a tree. The lock ends with this process, even if it is killed.
    try:
        hold_tree(Path(".snakemake"))
        # Files after those of the command line are the defaults that these are merged over.
        over = len(workflow.overwrite_configfiles)
        files = (*workflow.configfiles[over:], *workflow.configfiles[:over])
        store_configuration(STUDY, files, workflow.config_settings.config)
    except InputError as error:
        logger.error(str(error))
        sys.exit(1)
    if workflow.executor_plugin.name == "slurm":
        from skewbridge.study.processes import cancel_left_behind

        cancel_left_behind(workflow.executor_settings.jobname_prefix)
    elif workflow.executor_plugin.name == "local":
        os.environ[PROCESSORS] = str(workflow.cores)


onsuccess:
    for name in edited_meanwhile():
        logger.warning(
            f"{name} was edited while the study ran: the results are those of the earlier version; "
            "run the same command to update them."
        )
    if FOLDER.report.exists():
        logger.info(f"Report: {FOLDER.report}")


onerror:
    logger.error(f"The study stopped. {RESUME}")
