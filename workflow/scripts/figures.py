"""Draw the figures of the report."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.report.study_figures import draw_study

        on_request = snakemake.params.on_request
        choices = job.current(job.folder.modelling_choices, on_request["modelling_choices"])
        draw_study(
            {**job.inputs, **({"choices": choices} if choices else {})},
            folder=job.outputs["folder"],
            captions=job.outputs["captions"],
            settings=job.study.figures,
            provenance=job.stamp,
            n_jobs=snakemake.threads,
        )
