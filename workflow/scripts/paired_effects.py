"""Effect of friction, skew and gap on the demands: paired by motion, and their shares."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        import pandas as pd

        from skewbridge.demands.tables import provenance, write_frame
        from skewbridge.fragility.tables.effects import DEFAULT_DEMANDS, paired_effects
        from skewbridge.fragility.tables.factors import factor_summary
        from skewbridge.study.loading import parse_config

        settings = parse_config(snakemake.params.sections).fragility
        demands = pd.read_parquet(snakemake.input.demands)
        tables = {
            "effects": paired_effects(demands, bootstrap=settings.bootstrap, seed=settings.seed),
            "factors": factor_summary(demands, DEFAULT_DEMANDS),
        }
        for name, table in tables.items():
            write_frame(table, Path(snakemake.output[name]), provenance())
