"""Fit fragility curves, their paired medians, system curves and joint models to the demands."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.fragility.settings import FitSettings
        from skewbridge.fragility.tables.all_tables import fit_tables, write_tables
        from skewbridge.fragility.tables.limit_states import load_limit_states
        from skewbridge.provenance.tables import read_frame
        from skewbridge.reading import checked

        settings = checked(FitSettings, snakemake.params.fragility, "fragility")
        demands, suite = (read_frame(Path(snakemake.input[name])) for name in ("demands", "suite"))
        states = load_limit_states(Path(snakemake.input.limit_states))
        tables = fit_tables(demands, states, settings, suite, jobs=snakemake.threads)
        write_tables(tables, Path(snakemake.output.curves).parent)
