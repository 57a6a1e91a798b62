"""Combine tables and figures in one self-contained page."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.report.checks import require_passed
        from skewbridge.report.page import write_report

        if job.study.checks == "strict":
            require_passed(job.inputs["checks"])
        on_request = snakemake.params.on_request
        choices = job.current(job.folder.modelling_choices, on_request["modelling_choices"])
        write_report(
            tables={**job.inputs, **({"choices": choices} if choices else {})},
            figures=job.folder.figures,
            study=job.study,
            output=job.outputs["html"],
        )
