"""Effect of friction, skew and gap on the demands: paired by motion, and their shares."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.fragility.settings import FragilityConfig
        from skewbridge.fragility.tables.effects import DEFAULT_DEMANDS, paired_effects
        from skewbridge.fragility.tables.factors import factor_summary
        from skewbridge.provenance.tables import provenance, read_frame, write_frame
        from skewbridge.reading import checked

        settings = checked(FragilityConfig, snakemake.params.fragility, "fragility")
        demands = read_frame(snakemake.input.demands)
        tables = {
            "effects": paired_effects(demands, bootstrap=settings.bootstrap, seed=settings.seed),
            "factors": factor_summary(demands, DEFAULT_DEMANDS),
        }
        for name, table in tables.items():
            write_frame(table, Path(snakemake.output[name]), provenance())
