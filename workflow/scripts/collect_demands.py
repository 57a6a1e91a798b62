"""Join the demands of all variants into one checked table."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.demands.tables import collect_demands

        collect_demands(map(Path, snakemake.input.demands), Path(snakemake.output.demands))
