"""Fit fragility curves to the demands."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        import pandas as pd

        from skewbridge.demands.parquet import provenance, write_frame
        from skewbridge.fragility.limit_states import load_limit_states
        from skewbridge.fragility.study_fits import fit_study
        from skewbridge.study.config import FragilityConfig

        settings = FragilityConfig(**snakemake.params.fragility)
        curves = fit_study(
            pd.read_parquet(snakemake.input.demands),
            load_limit_states(Path(snakemake.input.limit_states)),
            im_column=settings.im,
            level=settings.confidence,
            bootstrap=settings.bootstrap,
            seed=settings.seed,
        )
        write_frame(curves, Path(snakemake.output.curves), provenance())
