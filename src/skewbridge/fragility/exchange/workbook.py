"""Tables as a workbook for spreadsheets: one sheet each."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd


def write_workbook(sheets: Mapping[str, pd.DataFrame], path: Path) -> None:
    """Write an .xlsx file; texts are never formulas, infinite numbers are written as such.

    Args:
        sheets: Tables by the name of their sheet.
        path: File to write.

    Raises:
        OSError: The file cannot be written.
    """
    plain = {"strings_to_formulas": False, "strings_to_urls": False}
    with pd.ExcelWriter(path, engine="xlsxwriter", engine_kwargs={"options": plain}) as writer:
        for name, table in sheets.items():
            table.to_excel(writer, sheet_name=name, index=False, inf_rep="infinity")
            writer.sheets[name].freeze_panes(1, 0)
            writer.sheets[name].autofit()
