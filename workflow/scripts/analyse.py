"""Analyse one variant under all motions; each finished analysis goes to the journal at once."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.analyses import analyse_variant

        analyse_variant(job.setup, snakemake.wildcards.variant, job.outputs["demands"])
