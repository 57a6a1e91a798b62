"""Cost of the contact update in microseconds per unit and step. Target: 5.

Fourteen units in space, as at the two ends of a bridge: all closed and sliding, all open, or
without updates of friction. Only the processor time of `ContactSet.after_step` counts.
    python benchmarks/contact_update.py [--repeats 5]
"""

import sys
import time

import openseespy.opensees as ops
from common import options, show

from skewbridge.contact import ContactSet

UNITS, STEPS, DT_S = 14, 2000, 1e-3
STATES = ("closed and sliding", "open", "without updates")


def make(state: str) -> ContactSet:
    """Build the units of a state: masses pressed onto skew walls and pushed along them."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    contacts = ContactSet(update=state != "without updates")
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    for unit in range(UNITS):
        wall, body = 2 * unit + 1, 2 * unit + 2
        for node in (wall, body):
            ops.node(node, 0.0, 0.0, 0.0)
        ops.fix(wall, *[1] * 6)
        ops.fix(body, 0, 0, 0, 1, 1, 1)
        ops.mass(body, 1e3, 1e3, 1e3, 0.0, 0.0, 0.0)
        gap_m = 1e6 if state == "open" else 0.0
        contacts.add(wall, body, (0.6, 0.8, 0.0), gap_m, 0.3, 1500.0, kn=1e6, kt=1e6)
        ops.load(body, -3.6e3, -4.8e3, 3e3, 0.0, 0.0, 0.0)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", 1e-8, 20)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    return contacts


def microseconds_per_unit(state: str) -> float:
    """Return the mean processor time of the update per unit and step, in microseconds."""
    contacts = make(state)
    spent = 0
    for _ in range(STEPS):
        if ops.analyze(1, DT_S) != 0:
            sys.exit("the benchmark model does not converge")
        start = time.process_time_ns()
        contacts.after_step(DT_S)
        spent += time.process_time_ns() - start
    ops.wipe()
    return spent / 1e3 / STEPS / UNITS


if __name__ == "__main__":
    repeats = options(__doc__, repeats=5).repeats
    # the smallest of several repeats, because other processes can only add time
    found = {state: min(microseconds_per_unit(state) for _ in range(repeats)) for state in STATES}
    show({"microseconds_per_contact_and_step": found, "target": 5.0})
