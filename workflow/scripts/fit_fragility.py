"""Write every table of results/fragility: fits, effects, joint models, systems."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.fragility.limit_states import load_limit_states
        from skewbridge.fragility.settings import FitSettings
        from skewbridge.fragility.study_tables import fragility_tables, write_tables
        from skewbridge.provenance.tables import read_frame
        from skewbridge.reading import checked

        settings = checked(FitSettings, snakemake.params.fragility, "fragility")
        demands, suite = (read_frame(Path(snakemake.input[name])) for name in ("demands", "suite"))
        states = load_limit_states(Path(snakemake.input.limit_states))
        tables = fragility_tables(demands, states, settings, suite, jobs=snakemake.threads)
        write_tables(tables, Path(snakemake.output.curves).parent)
