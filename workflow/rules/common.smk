# What the rules share: the validated configuration, its folder and variants, digests. No rules.
from snakemake.exceptions import WorkflowError
from snakemake.settings.enums import RerunTrigger
from snakemake_interface_executor_plugins.settings import ExecMode

from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.errors import InputError
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.motions.content import content_digest
from skewbridge.provenance.digests import digest_of, opensees_version, source_digest
from skewbridge.provenance.files import writable_folder
from skewbridge.provenance.tables import is_made_for
from skewbridge.study.folder import StudyFolder
from skewbridge.analysis.keys import bridge_digest
from skewbridge.study.chosen_variants import chosen_variants
from skewbridge.study.config import parse_config, plain_sections
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.variant import parse_slug

# The bridge whose conditioning period sets the factors of every study (design, section 5).
CONDITIONING_BRIDGE = "osb1"

try:
    STUDY = parse_config(config)
    FOLDER = StudyFolder(writable_folder(Path(STUDY.results)))
    BRIDGES = {Path(name).stem: bridge_digest(name) for name in STUDY.grid.bridge}
    T1_S = {name: load_bridge(name).t1_s for name in STUDY.grid.bridge}
    CONDITIONING_T1_S = load_bridge(CONDITIONING_BRIDGE).t1_s
    LIMIT_STATES = digest_of(load_limit_states(Path(STUDY.fragility.limit_states)))
    MOTIONS = content_digest(
        Path(STUDY.motions.folder),
        STUDY.motions.count,
        t1_s=CONDITIONING_T1_S,
        level_range_g=tuple(STUDY.motions.level_range_g),
        cache=FOLDER.motions_digest,
    )
    VARIANTS = {variant.slug: variant for variant in expand_grid(STUDY.grid)}
    CHANGED = chosen_variants(VARIANTS.values(), STUDY.modelling_choices.variants)
except InputError as error:
    raise WorkflowError(str(error)) from None

# The variants with most friction, of which the numerical checks take rows.
MOST_FRICTION = max(variant.friction_pct for variant in VARIANTS.values())
SAMPLED = [name for name, v in VARIANTS.items() if v.friction_pct == MOST_FRICTION]


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
ANALYSIS_SECTIONS = {
    "motions": section("motions"),
    "model": section("model"),
    "analysis": section("analysis"),
}


def parts_of_study(_wildcards):
    """The parts that the analyses are cut into now; see the rule `analyse`.

    On a cluster the main process decides it; a job that joins the parts on a node finds them there.
    """
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
    return digest_of(source_digest(path, shown=shown), *before)


def trust_contents():
    """Let the parameters and the contents of files tell what has changed.

    The times of files and scripts, which a copied tree changes, do not, and neither do the names of
    inputs, which change with the number of parts that the analyses are cut into. To be called when
    the settings of the run are known and before the jobs are planned, as the inputs of a target are.
    """
    workflow.dag_settings.rerun_triggers -= {RerunTrigger.CODE, RerunTrigger.INPUT}
    for holder in (workflow.dag, workflow.persistence):
        holder.max_checksum_file_size = sys.maxsize


def study_products(_wildcards):
    """What the whole study makes."""
    trust_contents()
    return [FOLDER.plan, FOLDER.report, FOLDER.checks]


def choice_products(_wildcards):
    """What `make choices` makes."""
    trust_contents()
    return FOLDER.modelling_choices


onstart:
    if workflow.executor_plugin.name == "slurm":
        from skewbridge.study.cluster import cancel_left_behind

        cancel_left_behind(workflow.executor_settings.jobname_prefix)


onsuccess:
    if FOLDER.report.exists():
        logger.info(f"Report: {FOLDER.report}")


onerror:
    logger.error(
        "The study stopped. What is finished stays finished: the same command goes on from there."
    )
