"""
Stribeck friction law
=====================

Coefficient of friction against sliding speed (``skewbridge.contact.drives``).
"""

import matplotlib.pyplot as plt
import numpy as np

from skewbridge.contact.drives import stribeck_friction

speed_mps = np.linspace(0.0, 0.5, 200)
for kinetic in (0.2, 0.3, 0.4):
    friction = [
        stribeck_friction(v, static=0.5, kinetic=kinetic, stribeck_speed_mps=0.1) for v in speed_mps
    ]
    plt.plot(speed_mps, friction, label=f"kinetic {kinetic}")
plt.xlabel("sliding speed (m/s)")
plt.ylabel("coefficient of friction")
plt.legend()
