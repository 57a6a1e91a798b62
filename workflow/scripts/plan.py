"""List the analyses of the study, so that every variant knows how far the whole is."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.loading import parse_config
        from skewbridge.study.runs import write_plan
        from skewbridge.study.setup import StudySetup

        setup = StudySetup.from_config(parse_config(snakemake.params.sections), snakemake.input)
        write_plan(setup, snakemake.params.variants, Path(snakemake.output.plan))
