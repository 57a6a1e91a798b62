"""Effect of friction, skew and gap on the demands, paired by motion."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        import pandas as pd

        from skewbridge.demands.parquet import provenance, write_frame
        from skewbridge.fragility.effects import paired_effects
        from skewbridge.study.config import FragilityConfig

        settings = FragilityConfig(**snakemake.params.fragility)
        effects = paired_effects(
            pd.read_parquet(snakemake.input.demands),
            bootstrap=settings.bootstrap,
            seed=settings.seed,
        )
        write_frame(effects, Path(snakemake.output.effects), provenance())
