"""Analyse one variant under every motion; rows to the journal, then to parquet."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.runs import analyse_variant
        from skewbridge.study.setup import StudySetup

        folder = StudyFolder(Path(snakemake.params.results))
        setup = StudySetup.from_sections(snakemake.params.sections, folder)
        analyse_variant(
            setup,
            snakemake.wildcards.variant,
            n_jobs=snakemake.threads,
            output=Path(snakemake.output.demands),
        )
