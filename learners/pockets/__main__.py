"""The former command of this training, ``python -m indoor_explorers.learners.pockets``."""

import sys

from indoor_explorers.learners.sessions.former import run_former

if __name__ == "__main__":
    sys.exit(run_former("pockets"))
