"""Compare other modelling choices with the configured model under a few motions."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.config import chosen_variants
        from skewbridge.study.modelling_choices import write_choices
        from skewbridge.variant.grid import expand_grid

        named = job.study.modelling_choices
        write_choices(
            job.setup,
            chosen_variants(expand_grid(job.study.grid), named.variants),
            job.study.grid.values(),
            named.motions,
            job.outputs["table"],
        )
