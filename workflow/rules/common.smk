# What the rules share: the validated configuration, its variants, digests. No rules.
from snakemake.exceptions import WorkflowError

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.study.loading import parse_config, require_writable
from skewbridge.variant.grid import expand_grid
from skewbridge.provenance.digests import ENGINE_ROOMS, digest_of, source_digest

try:
    STUDY = parse_config(config)
    require_writable(Path("results"))
    for name in STUDY.grid.bridge:
        load_bridge(name)
except InputError as error:
    raise WorkflowError(str(error)) from None

VARIANTS = {variant.slug: variant for variant in expand_grid(STUDY.grid)}


wildcard_constraints:
    variant="|".join(VARIANTS),


def section(name):
    """One section of the configuration as plain values, for `params`."""
    return getattr(STUDY, name).model_dump()


# What an analysis depends on besides its variant and its motion.
ANALYSIS_SECTIONS = {
    "motions": section("motions"),
    "model": section("model"),
    "analysis": section("analysis"),
}


def folder_state(folder):
    """Digest of the files of a folder: a changed, new or removed record is read again."""
    files = sorted(path for path in Path(folder).rglob("*") if path.is_file())
    return digest_of(
        *((str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in files)
    )


onerror:
    logger.error(
        "The study stopped. What is finished stays finished: the same command goes on from there."
    )
