# A gate: nothing is analysed with a broken contact law.
rule verify_contact:
    output:
        table="results/verification/contact_gate.parquet",
    log:
        "results/logs/verify_contact.log",
    params:
        digest=source_digest("units", "contact", "verification"),
    script:
        "../scripts/verify_contact.py"


# The paper's studies against independent references; not part of the default target.
rule verification:
    output:
        table="results/verification/studies.parquet",
    log:
        "results/logs/verification.log",
    params:
        digest=source_digest(*ENGINE_ROOMS, "verification"),
    script:
        "../scripts/verification.py"
