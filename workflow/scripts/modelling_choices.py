"""Compare other modelling choices with the configured model under a few motions."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.modelling_choices import chosen_variants, write_choices
        from skewbridge.variant.grid import expand_grid

        variants = chosen_variants(expand_grid(job.study.grid))
        write_choices(job.setup, variants, job.study.grid.values(), job.outputs["table"])
