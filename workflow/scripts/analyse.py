"""Analyse one part of the study; rows to the journal, then to the file of the part."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.guard import Workers
        from skewbridge.study.runs import analyse_part

        analyse_part(
            StudyFolder(Path(snakemake.input.plan).parent),
            number=int(snakemake.wildcards.part),
            count=int(snakemake.wildcards.parts),
            workers=Workers(
                count=snakemake.threads, no_progress_s=snakemake.resources.no_progress_s
            ),
            output=Path(snakemake.output.rows),
        )
