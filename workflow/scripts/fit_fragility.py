"""Write every table of results/fragility, and check the tables of the study."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.files.tables import read_frame
        from skewbridge.fragility.limit_states import load_limit_states
        from skewbridge.fragility.study_tables import fragility_tables, valid_tables, write_tables
        from skewbridge.motions.blocks import placed, planned_runs
        from skewbridge.motions.suite import read_suite
        from skewbridge.report.checks import StudyTables, write_checks
        from skewbridge.variant.options import SHEAR_MODEL_DEMANDS

        study, paths = job.study, {**job.inputs, **job.outputs}
        demands = read_frame(paths["demands"])
        if study.model.shear_failure == "degrade":  # the response depends on the shear capacity
            demands = demands[[n for n in demands if n not in SHEAR_MODEL_DEMANDS.values()]]
        states = load_limit_states(paths["limit_states"])
        further = {"hazard": study.hazard_curve, "jobs": snakemake.threads}
        tables = fragility_tables(demands, states, study.fragility, **further)
        if "rounds" in paths:
            rounds = read_frame(paths["rounds"])
            tables = valid_tables(tables, demands, rounds, study.design.looks)
        write_tables(tables, paths["curves"].parent)
        rows = placed(read_suite(paths["suite"]))
        runs = planned_runs(study.grid, study.motions, rows)
        checked = StudyTables(
            demands=demands,
            curves=tables["curves"],
            effects=tables["effects"],
            cohesion_n=study.model.cohesion_n,
            planned={slug: len(of_variant) for slug, of_variant in runs.items()},
            searched=study.motions.design == "ida",
            in_rounds="rounds" in paths,
        )
        write_checks(checked, paths["checks"])
