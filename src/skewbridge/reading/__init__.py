"""Reading of files and checking of their values, within limits and with clear messages."""

from skewbridge.reading.checking import FileName, Number, Whole, checked, merged
from skewbridge.reading.files import (
    no_formula,
    parse_yaml,
    read_bytes,
    read_csv,
    read_json,
    read_mapping,
    read_text,
    read_yaml,
    records_of,
    shortened,
    shown_path,
)

__all__ = [
    "FileName",
    "Number",
    "Whole",
    "checked",
    "merged",
    "no_formula",
    "parse_yaml",
    "read_bytes",
    "read_csv",
    "read_json",
    "read_mapping",
    "read_text",
    "read_yaml",
    "records_of",
    "shortened",
    "shown_path",
]
