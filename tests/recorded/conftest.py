"""Tests of recorded motions: collected only where `SKEWBRIDGE_RECORDS` names a folder of them."""

import os

collect_ignore_glob = [] if os.environ.get("SKEWBRIDGE_RECORDS") else ["test_*.py"]
