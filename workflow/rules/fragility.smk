rule fit_fragility:
    input:
        demands="results/demands.parquet",
        limit_states=STUDY.fragility.limit_states,
    output:
        curves="results/fragility/curves.parquet",
        medians="results/fragility/median_effects.parquet",
        system="results/fragility/system.parquet",
    log:
        "results/logs/fit_fragility.log",
    params:
        sections=plain_sections(STUDY, "fragility"),
        digest=source_digest("fragility"),
    script:
        "../scripts/fit_fragility.py"


rule paired_effects:
    input:
        demands="results/demands.parquet",
    output:
        effects="results/fragility/effects.parquet",
        factors="results/fragility/factors.parquet",
    log:
        "results/logs/paired_effects.log",
    params:
        sections=plain_sections(STUDY, "fragility"),
        digest=source_digest("fragility"),
    script:
        "../scripts/paired_effects.py"
