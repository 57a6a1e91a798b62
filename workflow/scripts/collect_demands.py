"""Join the demands of all variants into one checked table."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.analysis.suspect import SuspectLimits
        from skewbridge.demands.tables import collect_demands
        from skewbridge.reading import checked

        collect_demands(
            map(Path, snakemake.input.demands),
            Path(snakemake.output.demands),
            checked(SuspectLimits, snakemake.params.suspect, "suspect"),
        )
