"""Upkeep of the journals of a study that does not run: lines that do not count, failed analyses."""

from collections.abc import Collection

from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import JournalContent, Row, compact, open_journal, read_content


def compact_journals(folder: StudyFolder) -> JournalContent:
    """Drop all lines that do not count, and return what the journals held.

    Raises:
        InputError: The study runs.
    """
    content = read_content(folder.journals)
    for path in folder.journals:
        compact(path, lambda _row: True)
    return content


def forget(folder: StudyFolder, statuses: Collection[str]) -> list[Row]:
    """Take analyses out of the journals, so that the study tries them again.

    The table of demands goes, too: it is what the study then makes again, from the journals and
    these analyses.

    Args:
        folder: Where the study lies.
        statuses: What became of the analyses to forget.

    Returns:
        Their rows.

    Raises:
        InputError: The study runs.
    """
    rows = read_content(folder.journals).rows.values()
    forgotten = [row for row in rows if row["status"] in statuses]
    if forgotten:
        for path in folder.journals:
            with open_journal(path):
                pass  # nothing is touched while one of them is written
        folder.demands.unlink(missing_ok=True)
        for path in folder.journals:
            compact(path, lambda row: row["status"] not in statuses)
    return forgotten
