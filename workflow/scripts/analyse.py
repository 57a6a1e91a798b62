"""Analyse one variant; each finished analysis goes to the journal at once."""

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.analyses import StudySetup, analyse_variant

        setup, variant = StudySetup.of(job.study), snakemake.wildcards.variant
        if "plan" in job.inputs:
            from skewbridge.study.rounds import setup_of_round

            setup = setup_of_round(setup, job.inputs["plan"], variant)
        analyse_variant(
            setup,
            variant,
            workers=job.workers,
            limits=job.study.suspect,
            output=job.outputs["demands"],
        )
