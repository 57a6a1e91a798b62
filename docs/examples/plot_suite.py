"""
Scaled motions of a study
=========================

Spectra of the motions with their scale factors.
"""

from skewbridge.cli.study import DEMO_STUDY
from skewbridge.motions.suite import read_suite
from skewbridge.report.run_figures import applied_spectra
from skewbridge.study.folder import StudyFolder

figure = applied_spectra(read_suite(StudyFolder(DEMO_STUDY).suite))
