"""Engines, which fly episodes: worker processes of this machine, or a Ray cluster."""

import sys

from indoor_explorers.env.errors import InputError

if sys.platform == "win32":
    raise InputError(
        "comparisons fly in processes that are watched and ended by POSIX signals, got Windows; "
        "use the Windows Subsystem for Linux, where all of this package runs"
    )
