"""Compare predicted medians with analyses of variants inside the grid."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.fragility.settings import FitSettings
        from skewbridge.reading import checked
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.guard import Workers
        from skewbridge.study.predict_check import write_predict_check
        from skewbridge.study.setup import StudySetup

        parameters = snakemake.params
        folder = StudyFolder(Path(parameters.results))
        write_predict_check(
            StudySetup.from_sections(parameters.sections, folder),
            parameters.axes,
            {name: Path(snakemake.input[name]) for name in ("demands", "joint", "limit_states")},
            checked(FitSettings, parameters.fragility, "fragility"),
            workers=Workers(
                count=snakemake.threads, no_progress_s=snakemake.resources.no_progress_s
            ),
            output=Path(snakemake.output.table),
        )
