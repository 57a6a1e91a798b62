"""The process of the tests ends without OpenSees' message."""

from skewbridge.analysis.exit_message import hush_exit_message

hush_exit_message()
