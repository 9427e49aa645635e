"""The time limit of policies in these tests: a second on a machine that is otherwise idle."""

import os

from indoor_explorers.evaluation.harness.experiment.limits import Limits

#: Seconds of a decision: longer by as much as the machine is slowed down by other processes.
SECONDS = max(1.0, round(2 * os.getloadavg()[0] / (os.cpu_count() or 1), 1))
LIMITS = Limits(decision_timeout=SECONDS, memory=2_000_000_000)
#: For everything that ends by itself, however busy the machine is.
PATIENT = LIMITS._replace(decision_timeout=60.0)
