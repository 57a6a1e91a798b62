# What the rules share: the validated configuration, its folder and variants, digests. No rules.
import signal
from functools import cache

from skewbridge.study.orphans import end_all_on_interrupt

GOES_ON = "What is finished stays finished: the same command goes on from there."
end_all_on_interrupt(f"Interrupted. {GOES_ON}")

from snakemake.exceptions import WorkflowError
from snakemake.settings.enums import RerunTrigger
from snakemake_interface_executor_plugins.settings import ExecMode

from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.provenance.digests import digest_of, opensees_version, source_digest
from skewbridge.provenance.files import writable_folder
from skewbridge.provenance.syntax import SourceMemory
from skewbridge.reading import read_mapping
from skewbridge.study.folder import StudyFolder
from skewbridge.analysis.keys import bridge_digest
from skewbridge.study.made_for import tell_rules
from skewbridge.study.chosen_variants import chosen_variants
from skewbridge.study.config import (
    CONDITIONING_BRIDGE,
    analysis_sections,
    parse_config,
    plain_sections,
)
from skewbridge.study.inputs import check_inputs, motions_digest
from skewbridge.study.tree_lock import hold_tree
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.variant import parse_slug

CONFIG_AS_READ = {path: Path(path).read_bytes() for path in workflow.configfiles}

try:
    # Snakemake has read them already, but takes the last of equal keys.
    for path in workflow.configfiles:
        read_mapping(Path(path))
    STUDY = parse_config(config)
    FOLDER = StudyFolder(writable_folder(Path(STUDY.results)))
    check_inputs(STUDY, FOLDER.motions_digest)
    BRIDGES = {Path(name).stem: bridge_digest(name) for name in STUDY.grid.bridge}
    T1_S = {name: load_bridge(name).t1_s for name in STUDY.grid.bridge}
    CONDITIONING_T1_S = load_bridge(CONDITIONING_BRIDGE).t1_s
    LIMIT_STATES = digest_of(load_limit_states(Path(STUDY.fragility.limit_states)))
    MOTIONS = motions_digest(STUDY, FOLDER.motions_digest)
    VARIANTS = {variant.slug: variant for variant in expand_grid(STUDY.grid)}
    CHANGED = chosen_variants(VARIANTS.values(), STUDY.modelling_choices.variants)
except InputError as error:
    raise WorkflowError(str(error)) from None

# The variants with most friction, of which the numerical checks take rows.
MOST_FRICTION = max(variant.friction_pct for variant in VARIANTS.values())
SAMPLED = [name for name, v in VARIANTS.items() if v.friction_pct == MOST_FRICTION]


# What the sources say, kept from one run to the next: to read them takes seconds.
SOURCES_READ = SourceMemory(Path(".snakemake", "sources.jsonl"))


wildcard_constraints:
    part=r"[1-9]\d*",
    parts=r"[1-9]\d*",


def section(name):
    """One section of the configuration as plain values, for `params`."""
    return plain_sections(STUDY, name)[name]


def results_folder(_wildcards):
    """Where the study lies, for `params`."""
    return STUDY.results


def figures_folder(_wildcards):
    """Where its figures lie, for `params`."""
    return str(FOLDER.figures)


# What an analysis depends on besides its variant and its motion.
ANALYSIS_SECTIONS = analysis_sections(STUDY)


def parts_of_study(_wildcards):
    """The parts that the analyses are cut into now; see the rule `analyse`.

    On a cluster the main process decides it; a job that joins the parts on a node finds them there.
    """
    begin_run()
    if workflow.exec_mode != ExecMode.DEFAULT and (made := FOLDER.made_parts()):
        return made
    cpu_hours = STUDY.batches.cpu_hours
    if (
        cpu_hours is None
        and "analyse" in workflow.resource_settings.overwrite_resources
    ):
        of_job = workflow.resource_settings.overwrite_resources["analyse"]
        cpu_hours = of_job["cpu_minutes"].value / 60
    count = 1
    if cpu_hours is not None:
        from skewbridge.study.forecast import parts_of

        count = parts_of(STUDY, cpu_hours)
    return [FOLDER.part(number, count) for number in range(1, count + 1)]


def script_digest(script, *after, shown=False):
    """What a rule depends on besides its own parameters.

    That is its script with everything the script runs, and the parameters of the rules whose
    outputs it reads. With it the parameters of a rule tell the whole truth, also after a kill between
    two rules; the times of files do not count (`study_products`).

    Args:
        script: Name of the script, without ending.
        after: The rules whose outputs it reads, as `rules.name`.
        shown: Whether labels and titles count, for what draws figures or writes pages.
    """
    path = Path(workflow.basedir, "workflow", "scripts", f"{script}.py")
    before = [
        repr(value) for rule in after for value in rule.params if not callable(value)
    ]
    return digest_of(source_digest(path, shown=shown, memory=SOURCES_READ), *before)


@cache
def begin_run():
    """Let what the files say tell what is to be done, and hold the tree if this run changes it.

    The parameters and contents of files count. The times of files and scripts, which a copied tree
    changes, do not, and neither do the names of inputs, which change with the number of parts that
    the analyses are cut into. What a killed run has begun is made again.

    To be called when the settings of the run are known and before the jobs are planned, as the
    inputs of a target are.
    """
    workflow.dag_settings.rerun_triggers -= {RerunTrigger.CODE, RerunTrigger.INPUT}
    workflow.dag_settings.force_incomplete = True
    for holder in (workflow.dag, workflow.persistence):
        holder.max_checksum_file_size = sys.maxsize
    # Without an executor nothing runs (--report, --summary); on a node of a cluster a job comes here
    # again, for the main process that holds the tree.
    executes = workflow.executor_plugin is not None and not workflow.dryrun
    if executes and workflow.exec_mode == ExecMode.DEFAULT:
        try:
            hold_tree(Path(workflow.persistence.path))
        except InputError as error:
            logger.error(str(error))
            raise SystemExit(1) from None
        if not workflow.local_exec:  # Snakemake has jobs on a cluster to cancel
            signal.signal(signal.SIGINT, signal.default_int_handler)


def study_products(_wildcards):
    """What the whole study makes."""
    begin_run()
    return [FOLDER.plan, FOLDER.report, FOLDER.checks]


def choice_products(_wildcards):
    """What `make choices` makes."""
    begin_run()
    return FOLDER.modelling_choices


def predict_check_products(_wildcards):
    """Return the table of `make check-predict`."""
    begin_run()
    return FOLDER.fragility("check_predict")


def edited_meanwhile():
    """The configuration files that no longer say what this run has read."""
    return [
        str(path)
        for path, text in CONFIG_AS_READ.items()
        if not Path(path).is_file() or Path(path).read_bytes() != text
    ]


onstart:
    if workflow.executor_plugin.name == "slurm":
        from skewbridge.study.cluster import cancel_left_behind

        cancel_left_behind(workflow.executor_settings.jobname_prefix)


onsuccess:
    for name in edited_meanwhile():
        logger.warning(
            f"{name} was edited while the study ran: the results are those of the file as it was; "
            "the same command makes what the edit changes."
        )
    if FOLDER.report.exists():
        logger.info(f"Report: {FOLDER.report}")


onerror:
    logger.error(f"The study stopped. {GOES_ON}")
