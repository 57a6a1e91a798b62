"""Analyse one variant under all motions; store each finished analysis in the journal."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.analyses import analyse_variant

        analyse_variant(job.setup, snakemake.wildcards.variant, job.outputs["demands"])
