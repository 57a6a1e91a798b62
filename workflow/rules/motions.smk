rule prepare_motions:
    input:
        conditioning="src/skewbridge/bridge/catalogue/osb1.yaml",
    output:
        suite="results/motions/suite.parquet",
        intensities="results/motions/intensities.parquet",
    log:
        "results/logs/prepare_motions.log",
    params:
        sections=plain_sections(STUDY, "motions"),
        files=folder_state(STUDY.motions.folder),
        bridges=STUDY.grid.bridge,
        digest=source_digest("units", "motions"),
    script:
        "../scripts/prepare_motions.py"
