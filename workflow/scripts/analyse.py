"""Analyse one variant under all motions; each finished analysis goes to the journal at once."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.analyses import StudySetup, analyse_variant

        analyse_variant(
            StudySetup.of(job.study),
            snakemake.wildcards.variant,
            workers=job.workers,
            limits=job.study.suspect,
            output=job.outputs["demands"],
        )
