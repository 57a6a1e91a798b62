# What the rules share: the validated configuration, its variants, digests. No rules.
from snakemake.exceptions import WorkflowError

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.study.config import parse_config, require_writable
from skewbridge.study.grid import expand_grid
from skewbridge.study.provenance import ENGINE_ROOMS, source_digest

try:
    STUDY = parse_config(config)
    require_writable(Path("results"))
    for name in STUDY.grid.bridge:
        load_bridge(name)
except InputError as error:
    raise WorkflowError(str(error)) from None

VARIANTS = {variant.slug: variant for variant in expand_grid(STUDY.grid)}


wildcard_constraints:
    variant=r"[a-z][a-z0-9_]*_(ro|si|sp|co|cf)_skewm?\d{2}_gap\d{3}_mu\d{3}",


def section(name):
    """One section of the configuration as plain values, for `params`."""
    return getattr(STUDY, name).model_dump()


# What an analysis depends on besides its variant and its motion.
ANALYSIS_SECTIONS = {
    "incidence_deg": STUDY.motions.incidence_deg,
    "model": section("model"),
    "analysis": section("analysis"),
}


def motion_files(wildcards):
    """Every file of the motion folder: a changed record is read again."""
    return sorted(
        str(path)
        for path in Path(STUDY.motions.folder).rglob("*")
        if path.is_file() and not path.name.startswith(".") and path.suffix != ".md"
    )


onerror:
    logger.error(
        "The study stopped. What is finished stays finished: the same command goes on from there."
    )
