"""Repeat a few analyses with halved and doubled penalties and time step."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.loading import parse_config
        from skewbridge.study.sensitivity import write_sensitivity
        from skewbridge.study.setup import StudySetup

        setup = StudySetup.from_config(parse_config(snakemake.params.sections), snakemake.input)
        write_sensitivity(
            setup,
            snakemake.params.variant,
            count=snakemake.params.motions,
            n_jobs=snakemake.threads,
            output=Path(snakemake.output.table),
        )
