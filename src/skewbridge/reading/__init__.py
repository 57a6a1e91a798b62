"""The one way from a file to checked values, within limits; what is wrong becomes a sentence."""

from skewbridge.reading.checking import FileName, Number, Whole, checked, merged
from skewbridge.reading.documents import parse_yaml, read_json, read_mapping, read_yaml
from skewbridge.reading.files import read_bytes, read_text, shortened

__all__ = [
    "FileName",
    "Number",
    "Whole",
    "checked",
    "merged",
    "parse_yaml",
    "read_bytes",
    "read_json",
    "read_mapping",
    "read_text",
    "read_yaml",
    "shortened",
]
