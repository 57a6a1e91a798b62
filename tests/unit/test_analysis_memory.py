"""The memory of a process does not grow with the number of its analyses."""

import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
MAX_MB = 400.0
MAX_GROWTH_MB = 4.0  # a thread's arena that the allocator takes late; a leak would be far more

SCRIPT = """
import psutil
from strong_motion import strong_motion
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

motion, settings = strong_motion(), AnalysisSettings(duration_s=0.05)
for number in range(200):
    case = Variant(bridge="osb1", abutment="contact_friction", skew_deg=15 * (number % 4),
                   gap_mm=51, friction_pct=50)
    analyse(case, Excitation(motion=motion), settings, ModelOptions(), histories=True)
    if number in (19, 199):
        print(psutil.Process().memory_info().rss / 2**20)
"""


def test_two_hundred_analyses_in_one_process_keep_its_memory_flat():
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=TESTS, capture_output=True, text=True, check=True
    )
    early_mb, late_mb = (float(line) for line in done.stdout.split())
    assert late_mb < MAX_MB
    assert late_mb - early_mb < MAX_GROWTH_MB
