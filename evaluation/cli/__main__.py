"""``python -m indoor_explorers.evaluation.cli``: the command ``indoor-explorers``."""

import sys

from indoor_explorers.evaluation.cli import main

sys.exit(main())
