"""From a file and options to a fit: the work behind `skewbridge fit`."""

from pathlib import Path

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_data, select_rows
from skewbridge.fragility.exchange.fit_columns import fit_columns
from skewbridge.fragility.exchange.fit_options import FitOptions
from skewbridge.fragility.exchange.foreign import read_mapped
from skewbridge.fragility.exchange.run_table import fit_run_table
from skewbridge.fragility.old_likelihood.fit import FragilityFit
from skewbridge.reading.files import shown_path


def fit_file(path: Path, options: FitOptions) -> FragilityFit:
    """Fit the data of a JSON, CSV or parquet file.

    Raises:
        InputError: The file or a value in it is unusable: names the file, the column and the row.
    """
    if options.columns is None:
        data = read_data(path, options.where)
    else:
        data = select_rows(read_mapped(path, options.columns), options.where)
    try:
        if options.edp is not None or options.im is not None:
            return fit_run_table(data, options)
        return fit_columns(dict(data), options)
    except InputError as error:
        if not {"row", "column"} & error.details.keys():  # of the options
            raise
        told, details = f"{shown_path(path)}: {error}", {"file": str(path), **error.details}
        row = details.get("row")
        if options.where is not None and isinstance(row, int) and isinstance(data, pd.DataFrame):
            of_file = int(data.index.to_numpy()[row])
            told += f" of the {len(data)} selected; row {of_file} of the file"
            details["row"] = of_file
        raise InputError(told, **details) from error
