"""
Motions as applied
==================

Spectra of the motions of a study with their factors.
"""

from skewbridge.cli.study import DEMO_STUDY
from skewbridge.motions.suite import read_suite
from skewbridge.report.motion_figures import applied_spectra
from skewbridge.study.folder import StudyFolder

figure = applied_spectra(read_suite(StudyFolder(DEMO_STUDY).suite))
