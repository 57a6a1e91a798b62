rule figures:
    input:
        demands="results/demands.parquet",
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
        curves="results/fragility/curves.parquet",
        effects="results/fragility/effects.parquet",
    output:
        folder=directory("results/figures"),
    log:
        "results/logs/figures.log",
    params:
        im=STUDY.fragility.im,
        sections=ANALYSIS_SECTIONS,
        digest=source_digest("report", *ENGINE_ROOMS),
    script:
        "../scripts/figures.py"


rule check_results:
    input:
        demands="results/demands.parquet",
        curves="results/fragility/curves.parquet",
        effects="results/fragility/effects.parquet",
    output:
        checks="results/checks.json",
    log:
        "results/logs/check_results.log",
    params:
        digest=source_digest("demands"),
    script:
        "../scripts/check_results.py"


rule report:
    input:
        figures="results/figures",
        demands="results/demands.parquet",
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
        gate="results/verification/contact_gate.parquet",
        curves="results/fragility/curves.parquet",
        effects="results/fragility/effects.parquet",
        factors="results/fragility/factors.parquet",
        medians="results/fragility/median_effects.parquet",
        system="results/fragility/system.parquet",
        checks="results/checks.json",
        sensitivity="results/sensitivity.parquet",
    output:
        html="results/report.html",
    log:
        "results/logs/report.log",
    params:
        config=STUDY.model_dump(mode="json"),
        digest=source_digest("report"),
    script:
        "../scripts/report.py"
