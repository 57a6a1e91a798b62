"""From the configuration to the job of a variant, its journal as a cache, and the joined table."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest

from skewbridge.demands.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.demands.tables import join_variants, to_table
from skewbridge.errors import InputError
from skewbridge.files import tables as provenance_tables
from skewbridge.study.analyses import StudySetup, analyse_variant
from skewbridge.study.batch import Workers
from skewbridge.study.config import StudyConfig, parse_config
from skewbridge.study.ida import Search, at_factor
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.progress import forecast_study, study_state
from skewbridge.study.task import Task, run_key
from skewbridge.variant.grid import expand_grid
from study_parts import row_of, study_of, wave

SLUGS = (
    "osb1_cf_skew30_gap025_mu000",
    "osb1_cf_skew30_gap025_mu050",
    "osb1_ro_skew30_gap000_mu000",
)


def setup_in(folder: Path, lengths_s: Sequence[float] = (1.0, 3.0, 2.0)) -> StudySetup:
    return study_of(folder, *(wave(f"m{s:g}", duration_s=s, number=s) for s in lengths_s))


def test_the_analysis_of_a_row_is_found_also_in_a_search(tmp_path: Path) -> None:
    plain = setup_in(tmp_path)
    search = Search(demand="deck_disp_m", threshold=0.1, low_g=0.1, high_g=2.0)
    searching = replace(plain, search=search)
    first = searching.tasks(SLUGS[1])[1]
    for setup, task in (
        (plain, plain.tasks(SLUGS[1])[2]),
        (searching, first),
        (searching, at_factor(first, 1.37)),
    ):
        found = setup.task_of(row_of(task))
        assert found is not None
        assert run_key(found) == run_key(task)
        assert found.motion.measures == task.motion.measures
    assert plain.task_of(row_of(at_factor(first, 1.37))) is None
    with pytest.raises(InputError, match=r"osb2s_.*: the study has the bridges osb1"):
        plain.tasks("osb2s_cf_skew30_gap025_mu050")


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the motions that workers were asked for, in their order."""
    asked: list[str] = []

    def stream(
        _pool: object, pending: Sequence[tuple[int, Task, str]]
    ) -> Iterator[tuple[int, list[dict[str, object]]]]:
        asked.extend(task.motion.motion.motion_id for _, task, _ in pending)
        yield from ((number, [row_of(task)]) for number, task, _ in reversed(pending))

    monkeypatch.setattr("skewbridge.study.batch._Pool.stream", stream)
    return asked


def analyse(setup: StudySetup, slug: str) -> Path:
    output = setup.folder.variant_demands(slug)
    analyse_variant(setup, slug, workers=Workers(count=1), limits=SuspectLimits(), output=output)
    return output


def test_the_longest_analyses_of_a_variant_begin_first(tmp_path: Path, ran: list[str]) -> None:
    setup = setup_in(tmp_path)
    table = pd.read_parquet(analyse(setup, SLUGS[0]))
    assert ran == ["m3", "m2", "m1"]
    assert table["motion_id"].tolist() == ["m1", "m2", "m3"]


def test_a_job_repeats_nothing_that_its_journal_has(tmp_path: Path, ran: list[str]) -> None:
    setup = setup_in(tmp_path)
    (shorter, *_) = (setup_in(tmp_path, (1.0, 3.0)).tasks(SLUGS[0]),)
    with open_journal(setup.folder.journal(SLUGS[0])) as journal:
        journal.append(row_of(shorter[1]))
    first = pd.read_parquet(analyse(setup, SLUGS[0]))
    assert ran == ["m2", "m1"]
    again = pd.read_parquet(analyse(setup, SLUGS[0]))
    assert ran == ["m2", "m1"]
    pd.testing.assert_frame_equal(first, again)


def test_a_variant_that_another_process_analyses_is_refused(
    tmp_path: Path, ran: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skewbridge.study.analyses.PREDECESSOR_S", 0.0)
    setup = setup_in(tmp_path)
    with (
        open_journal(setup.folder.journal(SLUGS[0])),
        pytest.raises(InputError, match="being written by another process"),
    ):
        analyse(setup, SLUGS[0])
    assert not ran


def test_the_joined_table_is_that_of_all_rows_at_once(
    tmp_path: Path, ran: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However few rows are held at a time, the file has all of them in the order of the key."""
    monkeypatch.setattr(provenance_tables, "_GROUP_ROWS", 4)
    setup, limits = setup_in(tmp_path), SuspectLimits()
    join_variants([analyse(setup, slug) for slug in SLUGS], setup.folder.demands)
    rows = [row_of(task) for slug in reversed(SLUGS) for task in setup.tasks(slug)]
    whole = to_table([{**row, SUSPECT: reasons(row, limits)} for row in rows], {})
    file = pq.ParquetFile(setup.folder.demands)
    assert file.num_row_groups == 2
    pd.testing.assert_frame_equal(file.read().to_pandas(), whole.to_pandas(), check_exact=True)
    assert [field.metadata for field in file.schema_arrow] == [
        field.metadata for field in whole.schema
    ]


def test_every_journal_of_the_folder_counts(tmp_path: Path) -> None:
    """What is done is done, by whatever job."""
    setup = setup_in(tmp_path)
    tasks = setup.tasks(SLUGS[0])
    for name, task in zip((SLUGS[0], "pilot", "sensitivity"), tasks, strict=True):
        with open_journal(setup.folder.journal(name)) as journal:
            journal.append(row_of(task))
    keys = {slug: [run_key(task) for task in setup.tasks(slug)] for slug in SLUGS[:2]}
    state = study_state(keys, read_content(setup.folder.journals))
    assert [state.counts[name] for name in ("analyses", "done", "left")] == [6, 3, 3]
    assert state.variants_left == 1


def test_the_cost_of_a_study_of_searches_is_that_of_all_their_analyses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    given, searching = (
        forecast_study(
            parse_config(
                {
                    "results": str(tmp_path),
                    "motions": {"design": design, "level_range_g": [0.05, 5.0]},
                }
            )
        )
        for design in ("scaled_cloud", "ida")
    )
    assert searching.summary["analyses"] == given.summary["analyses"]
    assert searching.summary["core_hours"] == pytest.approx(
        10 * given.summary["core_hours"], rel=1e-3
    )
    assert searching.notes == ("Counted are searches of up to 10 analyses; the cost is of all.",)


def setup_of(study: StudyConfig) -> StudySetup:
    return study_of(
        "results", bridges=study.grid.bridge, settings=study.analysis, options=study.model
    )


def test_the_value_on_an_axis_overrides_the_configured_one() -> None:
    raw = {
        "grid": {"transverse_gap_mm": [12.5, 25.4], "backwall_points": [7]},
        "model": {"keys": "monolithic", "transverse_gap_mm": 3.0},
    }
    study = parse_config(raw)
    setup = setup_of(study)
    slugs = [variant.slug for variant in expand_grid(study.grid) if variant.skew_deg == 30]
    options = [setup.tasks(slug)[0].options for slug in slugs]
    assert {each.transverse_gap_m for each in options} == {0.0125, 0.0254}
    assert {(each.keys, each.backwall_points) for each in options} == {("monolithic", 7)}


def test_a_bridge_from_any_path_reaches_its_analyses(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("extends: osb1\nbase: fixed\n", encoding="utf-8")
    study = parse_config({"grid": {"bridge": [str(path), "osb1"], "abutment": ["roller"]}})
    setup = setup_of(study)
    task = setup.tasks("mine_ro_skew30_gap000_mu000")[0]
    assert task.variant.bridge == str(path)
    assert task.variant.bridge_name == "mine"
    assert task.variant in expand_grid(study.grid)
