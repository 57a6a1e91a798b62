rule verify_contact:
    """Check the contact law before any analysis; a failed check stops the study."""
    output:
        table=FOLDER.contact_checks,
    log:
        FOLDER.log("verify_contact"),
    benchmark:
        FOLDER.benchmark("verify_contact")
    priority: 100
    resources:
        mem_mb=by_attempt(1500),
        runtime=by_attempt(30),
    params:
        results=results_folder,
        made_from=MADE_FROM["verify_contact"],
    script:
        "../scripts/verify_contact.py"


rule verification:
    """Compare the studies of the paper with references; not part of the default target."""
    output:
        table=FOLDER.verification / "studies.parquet",
        statements=FOLDER.verification / "statements.parquet",
    log:
        FOLDER.log("verification"),
    benchmark:
        FOLDER.benchmark("verification")
    resources:
        mem_mb=by_attempt(2000),
        runtime=by_attempt(240),
    params:
        results=results_folder,
        made_from=MADE_FROM["verification"],
    script:
        "../scripts/verification.py"
