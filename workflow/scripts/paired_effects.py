"""Effect of every axis on the demands: paired by motion, and their shares."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.fragility.settings import FitSettings
        from skewbridge.fragility.tables.all_tables import effect_tables, write_tables
        from skewbridge.provenance.tables import read_frame
        from skewbridge.reading import checked

        settings = checked(FitSettings, snakemake.params.fragility, "fragility")
        demands = read_frame(Path(snakemake.input.demands))
        tables = effect_tables(demands, settings, jobs=snakemake.threads)
        write_tables(tables, Path(snakemake.output.effects).parent)
