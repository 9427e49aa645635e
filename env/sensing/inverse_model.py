"""The inverse sensor model: the log-odds that one reading of a cell gives for its being occupied.

Values as in OctoMap (Hornung et al. 2013, section 5), rounded to fractions of 32: so sums of readings are exact in
single precision, whatever their order.
"""

from __future__ import annotations

import numpy as np

#: Log-odds of a reading that says occupied, and of one that says free: probabilities .706 and .4.
HIT, PASS = np.float32(0.875), np.float32(-0.40625)
#: Readings that a certain one is worth: that of the own cell, and of an obstacle that the UAV has flown into.
CERTAIN = np.float32(16.0)
