"""Repeat one analysis without and with friction, for the figures of histories."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        import pandas as pd

        from skewbridge.study.friction_pair import write_friction_pair
        from skewbridge.study.setup import StudySetup

        setup = StudySetup.from_sections(snakemake.params.sections, snakemake.input)
        demands = pd.read_parquet(snakemake.input.demands)
        write_friction_pair(setup, demands, Path(snakemake.output.histories))
