# What the rules share: the validated configuration, its variants, digests. No rules.
from snakemake.exceptions import WorkflowError

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.provenance.digests import ENGINE_ROOMS, digest_of, source_digest
from skewbridge.provenance.files import writable_folder
from skewbridge.study.loading import parse_config, plain_sections
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.variant import SLUG_PATTERN

try:
    STUDY = parse_config(config)
    writable_folder(Path("results"))
    for name in STUDY.grid.bridge:
        load_bridge(name)
except InputError as error:
    raise WorkflowError(str(error)) from None

VARIANTS = {variant.slug: variant for variant in expand_grid(STUDY.grid)}


wildcard_constraints:
    variant=SLUG_PATTERN,


# What an analysis depends on besides its variant and its motion.
ANALYSIS_SECTIONS = plain_sections(STUDY, "motions", "model", "analysis")


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
