"""Spectra of the user's own NGA-West2 files (RSN*.AT2) against the published flatfile."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

from reference_data import reference_table
from skewbridge.motions.folder import group_by_name
from skewbridge.motions.intensity import motion_measures, pair_psa
from skewbridge.motions.read import read_motion
from skewbridge.units import G_MPS2

pytestmark = pytest.mark.skipif(
    not os.environ.get("SKEWBRIDGE_RECORDS"), reason="SKEWBRIDGE_RECORDS names no folder of records"
)
# The required tolerance is 0.2 % (1.2 % at 0.2 s with dt 0.02 s); the digits of the flatfile allow
# 0.01 %, and the largest difference found is 0.004 %.
FLATFILE_TOLERANCE = 1e-4
# The flatfile's velocities take g as 981 cm/s2 (0.034 % more than the standard gravity).
PGV_TOLERANCE = 5e-4


def test_rotd50_spectra_are_those_of_the_published_flatfile():
    flatfile = reference_table("nga_west2_rotd50").set_index("rsn")
    columns = [name for name in flatfile if name.startswith("psa_")]
    periods_s = [float(name.removeprefix("psa_")) for name in columns]
    folders = os.environ["SKEWBRIDGE_RECORDS"].split(os.pathsep)
    pairs = group_by_name(path for folder in folders for path in Path(folder).rglob("RSN*.AT2"))
    compared = 0
    for name, files in pairs.items():
        number = int(re.match(r"RSN(\d+)", name)[1])
        if number not in flatfile.index:
            continue
        compared += 1
        motion, published = read_motion(*files), flatfile.loc[number]
        psa = pair_psa(motion.accel_1_mps2, motion.accel_2_mps2, motion.dt_s, periods_s)
        np.testing.assert_allclose(
            psa.rotd50_mps2 / G_MPS2, published[columns].to_numpy(float), rtol=FLATFILE_TOLERANCE,
            err_msg=name,
        )  # fmt: skip
        measures = motion_measures(motion, None)
        assert measures["im_pga_rotd50_g"] == pytest.approx(published["pga_g"], rel=1e-4)
        assert measures["im_pgv_rotd50_mps"] == pytest.approx(
            published["pgv_cms"] / 100, rel=PGV_TOLERANCE
        )
    assert compared
