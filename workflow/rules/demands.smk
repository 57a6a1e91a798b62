# The list of analyses with their keys: from it every variant tells how far the whole study is. It is
# no input of theirs, because a variant does not depend on the others; it only comes first.
rule plan:
    input:
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
    output:
        plan="results/plan.json",
    log:
        "results/logs/plan.log",
    priority: 100
    params:
        variants=sorted(VARIANTS),
        sections=ANALYSIS_SECTIONS,
        digest=source_digest(*ENGINE_ROOMS),
    script:
        "../scripts/plan.py"


# One job per variant; joblib runs its analyses inside, on the threads of the job.
rule analyse_variant:
    input:
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
        gate="results/verification/contact_gate.parquet",
    output:
        demands="results/demands/{variant}.parquet",
    log:
        "results/logs/analyse/{variant}.log",
    benchmark:
        "results/benchmarks/{variant}.tsv"
    threads: min(2, workflow.cores)
    params:
        sections=ANALYSIS_SECTIONS,
        digest=source_digest(*ENGINE_ROOMS),
    script:
        "../scripts/analyse_variant.py"


rule collect_demands:
    input:
        demands=collect("results/demands/{variant}.parquet", variant=VARIANTS),
    output:
        demands="results/demands.parquet",
    log:
        "results/logs/collect_demands.log",
    params:
        digest=source_digest("demands"),
    script:
        "../scripts/collect_demands.py"


# One bridge under one motion, without and with friction, as histories for the figures.
rule friction_pair:
    input:
        demands="results/demands.parquet",
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
    output:
        histories="results/friction_pair.parquet",
    log:
        "results/logs/friction_pair.log",
    params:
        sections=ANALYSIS_SECTIONS,
        digest=source_digest(*ENGINE_ROOMS, "demands"),
    script:
        "../scripts/friction_pair.py"


# Penalties and time step halved and doubled on the hardest variant.
rule sensitivity:
    input:
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
        gate="results/verification/contact_gate.parquet",
    output:
        table="results/sensitivity.parquet",
    log:
        "results/logs/sensitivity.log",
    threads: min(2, workflow.cores)
    params:
        variant=max(
            VARIANTS.values(), key=lambda v: (v.friction_pct, abs(v.skew_deg))
        ).slug,
        motions=STUDY.sensitivity.motions,
        sections=ANALYSIS_SECTIONS,
        digest=source_digest(*ENGINE_ROOMS, "demands"),
    script:
        "../scripts/sensitivity.py"
