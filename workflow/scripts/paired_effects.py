"""Effect of every axis on the demands: paired by motion, and their shares."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.demands.columns import demands_for
        from skewbridge.fragility.settings import FitSettings
        from skewbridge.fragility.tables.effects import paired_effects
        from skewbridge.fragility.tables.factors import factor_summary
        from skewbridge.fragility.tables.needed_motions import needed_motions
        from skewbridge.fragility.tables.suspect_rows import rows_to_fit
        from skewbridge.provenance.tables import provenance, read_frame, write_frame
        from skewbridge.reading import checked

        settings = checked(FitSettings, snakemake.params.fragility, "fragility")
        demands = rows_to_fit(read_frame(snakemake.input.demands), settings)
        names = demands_for("effect", demands.columns)
        effects = paired_effects(demands, names, settings)
        tables = {
            "effects": effects,
            "factors": factor_summary(demands, names, settings),
            "needed_motions": needed_motions(effects, demands),
        }
        for name, table in tables.items():
            write_frame(table, Path(snakemake.output[name]), provenance())
