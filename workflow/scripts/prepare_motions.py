"""Read the motions, choose their factors and measure their intensity."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.loading import parse_config
        from skewbridge.study.setup import prepare_motions

        prepare_motions(
            parse_config(snakemake.params.sections).motions,
            bridges=snakemake.params.bridges,
            suite_path=Path(snakemake.output.suite),
            intensities_path=Path(snakemake.output.intensities),
        )
