"""`skewbridge.load`: frames with units and origin."""

import warnings
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest

import skewbridge
from skewbridge.errors import InputError
from skewbridge.files.tables import write_frame, write_table


def study(folder: Path, config_of_fits: str) -> Path:
    (folder / "fragility").mkdir()
    unit = pa.field("column_shear_kn", pa.float64(), metadata={"unit": "kN"})
    table = pa.table([pa.array([1.0])], schema=pa.schema([unit]))
    write_table(table.replace_schema_metadata({"config_digest": "abc"}), folder / "demands.parquet")
    origin = {"config_digest": config_of_fits}
    curve = {"skew_deg": 30.0, "im": "im_pga_rotd50_g", "theta": 0.5, "theta_low": 0.4}
    curve |= {"theta_bound_beta": 0.4, "beta": 0.3}
    write_frame(pd.DataFrame([curve]), folder / "fragility" / "curves.parquet", origin)
    return folder


def test_frames_have_units_and_origin(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = skewbridge.load(study(tmp_path, "abc"))
    assert found.demands.attrs["units"] == {"column_shear_kn": "kN"}
    units = {"skew_deg": "deg", "theta": "g", "theta_low": "g"}
    assert found.fragility["curves"].attrs["units"] == units
    assert found.fragility["curves"].attrs["provenance"]["config_digest"] == "abc"


def test_tables_of_different_origin_are_reported(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match=r"config_digest abc \(demands\), xyz \(curves\)"):
        skewbridge.load(study(tmp_path, "xyz"))


def test_a_folder_without_a_study_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no demands\.parquet"):
        skewbridge.load(tmp_path)
