"""Motion files with one quirk each, of one synthetic record, and the verdict each must get."""

from typing import Final

import numpy as np

from motions_files import at2_text, shaken_g

_DT_S: Final = 0.02
_RECORD_G: Final = shaken_g(0, 400)
_GOOD: Final = at2_text(_RECORD_G, _DT_S)
_HEAD, _VALUES = "".join(_GOOD.splitlines(keepends=True)[:4]), _GOOD.split("SEC\n")[1]


def _columns(dt_s: float, decimals: int) -> str:
    """Return time and acceleration in two columns."""
    rows = enumerate(_RECORD_G)
    return "".join(f"{i * dt_s + 1e-9:.{decimals}f} {value:.6e}\n" for i, value in rows)


def _one_per_line() -> str:
    return "".join(f"{value:.6e}\n" for value in _RECORD_G)


def _changed(old: str, new: str) -> str:
    if old not in _GOOD:
        raise ValueError(f"{old!r} is not in the good file")
    return _GOOD.replace(old, new, 1)


def _replaced_value(token: str) -> str:
    """Return the good file with another text in the columns of its eighth value."""
    start = len(_HEAD) + 76 + 30
    return _GOOD[:start] + token.rjust(15) + _GOOD[start + 15 :]


_TEXTS: Final = {
    "00_good.AT2": (_GOOD, "ok"),
    "01_crlf.AT2": (_GOOD.replace("\n", "\r\n"), "ok"),
    "02_blank_tail.AT2": (_GOOD + "\n  \n\n", "ok"),
    "03_no_final_newline.AT2": (_GOOD.rstrip("\n"), "ok"),
    # A download that broke off between two lines.
    "20_npts_too_big.AT2": (_changed("NPTS=    400", "NPTS=    500"), "warn"),
    # One that broke off within a number.
    "22_truncated_token.AT2": (_GOOD[:-33], "error"),
    "23_nan.AT2": (_replaced_value("NaN"), "error"),
    # Fortran writes stars where a number does not fit its columns.
    "24_stars.AT2": (_replaced_value("*" * 14), "error"),
    "26_empty.AT2": ("", "error"),
    "27_header_only.AT2": (_HEAD, "error"),
    "29_dt_zero.AT2": (_changed("DT= 0.0200", "DT= 0.0000"), "error"),
    "30_cms2_said_g.AT2": (at2_text(980.665 * _RECORD_G, _DT_S), "error"),
    # m/s2 said to be g cannot be told from the values: 1.5 g is a strong record.
    "32_ms2_said_g_small.AT2": (at2_text(5.0 * _RECORD_G, _DT_S), "ok"),
    "33_vt2.VT2": (
        _changed("ACCELERATION TIME SERIES IN UNITS OF G", "VELOCITY TIME SERIES IN UNITS OF CM/S"),
        "error",
    ),
    "34_offset.AT2": (at2_text(_RECORD_G + 0.05, _DT_S), "warn"),
    "35_html.AT2": ("<!DOCTYPE html><html><body>Please sign in</body></html>\n", "error"),
    "37_zip.AT2": ("PK\x03\x04\x14\x00\x00\x00", "error"),
    "38_bom_utf8.AT2": ("\ufeff" + _GOOD, "ok"),
    "39_all_zero.AT2": (at2_text(np.zeros(400), _DT_S), "error"),
    # Components of different length are a pair, of different time step they are none.
    "50_pair_len_h1.AT2": (_GOOD, "ok"),
    "51_pair_len_h2.AT2": (at2_text(_RECORD_G[:398], _DT_S), "ok"),
    "52_pair_dt_h2.AT2": (at2_text(_RECORD_G, 0.01), "pair_error"),
    "60_two_col.txt": (_columns(0.02, 4), "ok"),
    # A step of 0.0025 s cannot be told from a time column with three decimals.
    "61_two_col_rounded_time.txt": (_columns(0.0025, 3), "warn"),
    "63_one_col.txt": (_one_per_line(), "needs_dt"),
    "64_opensees.acc": (" ".join(f"{value:.6e}" for value in _RECORD_G), "needs_dt"),
}
MOTION_FILES: Final = {name: (text.encode(), verdict) for name, (text, verdict) in _TEXTS.items()}
