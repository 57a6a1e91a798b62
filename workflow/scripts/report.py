"""Join tables and figures in one self-contained page."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.report.html.page import write_report

        made = snakemake.params.choices
        write_report(
            tables={name: Path(path) for name, path in snakemake.input.items()},
            figures=Path(snakemake.params.figures),
            config=snakemake.params.config,
            choices=Path(made["table"]) if made else None,
            output=Path(snakemake.output.html),
        )
