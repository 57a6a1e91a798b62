"""
Contact in your own model
=========================

A stop with friction, 5 mm from the corner of a plane frame, added with ``ContactSet``.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import openseespy.opensees as ops

import skewbridge
from skewbridge.contact import ContactSet, make_step

sys.path.insert(0, str(Path(skewbridge.__file__).parents[2] / "docs"))
from foreign_models import portal_frame

portal_frame()
stops = ContactSet()
stops.add(9, 4, (-1.0, 0.0), 0.005, 0.4, kn=1e6, kt=1e6)
times, moves = [], []
for _ in range(1500):
    make_step(stops, 0.002)
    times.append(ops.getTime())
    moves.append(1000 * ops.nodeDisp(4, 1))
ops.wipe()
plt.plot(times, moves)
plt.axhline(5.0, color="grey", ls="--", label="stop")
plt.xlabel("time (s)")
plt.ylabel("displacement of the corner (mm)")
plt.legend()
