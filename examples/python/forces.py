"""Which wheel radius pulls best on dry sand? Force-slip curves of many wheels at once.

    python forces.py
"""

import numpy as np

import terra

slip = np.linspace(0.05, 0.95, 19)
radius = np.array([0.15, 0.20, 0.254, 0.30])[:, None]

forces = terra.wheel_forces("dry_sand", slip, 245.25, radius=radius, width=0.15)
pull = forces["drawbar_pull_N"]  # one row a radius, one column a slip

# Tractive efficiency: useful power over the axle's power, (D v)/(T w) with v = (1 - s) R w.
efficiency = pull * (1 - slip) * radius / forces["torque_N_m"]

for r, row, eta in zip(radius[:, 0], pull, efficiency):
    best = np.nanargmax(eta)
    print(
        f"R = {r:.3f} m: largest pull {np.nanmax(row):6.1f} N, "
        f"best efficiency {eta[best]:.2f} at slip {slip[best]:.2f}"
    )
