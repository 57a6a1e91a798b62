"""Fit fragility curves, their paired medians and the system curves to the demands."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        import pandas as pd

        from skewbridge.fragility.settings import FitSettings
        from skewbridge.fragility.tables.curves import fit_study
        from skewbridge.fragility.tables.im_quality import measure_table
        from skewbridge.fragility.tables.limit_states import load_limit_states
        from skewbridge.fragility.tables.median_effects import paired_capacity_effects
        from skewbridge.fragility.tables.ordered_curves import ordered_curves
        from skewbridge.fragility.tables.suspect_rows import rows_to_fit
        from skewbridge.fragility.tables.system_curves import system_curves
        from skewbridge.provenance.tables import provenance, read_frame, write_frame
        from skewbridge.reading import checked

        settings = checked(FitSettings, snakemake.params.fragility, "fragility")
        demands = rows_to_fit(read_frame(snakemake.input.demands), settings)
        states = load_limit_states(Path(snakemake.input.limit_states))
        curves = [
            fit(demands, states, settings.im, settings) for fit in (fit_study, ordered_curves)
        ]
        tables = {
            "curves": pd.concat(curves, ignore_index=True),
            "medians": paired_capacity_effects(demands, states, settings.im, settings),
            "system": system_curves(demands, states, settings.im, settings),
            "measures": measure_table(demands, read_frame(snakemake.input.suite), settings),
        }
        for name, table in tables.items():
            write_frame(table, Path(snakemake.output[name]), provenance())
