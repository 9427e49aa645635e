"""The former name of :mod:`indoor_explorers.env.observations`, kept for scripts that import it."""

from indoor_explorers.env.observations import *  # noqa: F403  # all public names
from indoor_explorers.env.observations import __all__ as __all__
