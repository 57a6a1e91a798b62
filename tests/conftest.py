"""The process of the tests ends without OpenSees' message."""

from skewbridge.study.processes import hush_exit_message

hush_exit_message()
