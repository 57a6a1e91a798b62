"""Analyse one variant under every motion; rows to the journal, then to parquet."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.loading import parse_config
        from skewbridge.study.runs import analyse_variant
        from skewbridge.study.setup import StudySetup

        setup = StudySetup.from_config(parse_config(snakemake.params.sections), snakemake.input)
        analyse_variant(
            setup,
            snakemake.wildcards.variant,
            n_jobs=snakemake.threads,
            output=Path(snakemake.output.demands),
        )
