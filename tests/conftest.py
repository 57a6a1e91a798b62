"""The process of the tests ends without OpenSees' message; hypothesis draws the same examples.

A change is not refused for an example that it did not bring. New examples are drawn by
`pytest --hypothesis-profile random tests/property`.
"""

from hypothesis import settings

from skewbridge.study.processes import hush_exit_message

hush_exit_message()
settings.register_profile("random", deadline=None)
settings.register_profile("repeatable", deadline=None, derandomize=True, database=None)
settings.load_profile("repeatable")
