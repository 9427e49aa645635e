"""Policies for the tests under the name of one module: honest ones and every way of being broken."""

from tests.evaluation.cheating import *  # noqa: F403
from tests.evaluation.failing import *  # noqa: F403
from tests.evaluation.honest import *  # noqa: F403
from tests.evaluation.honest import Wander

#: Whether :class:`Mended` is not mended yet.
BROKEN = True


class Mended(Wander):
    """Fail until it is mended."""

    def pilot(self, briefing):
        if BROKEN:
            raise RuntimeError("not mended yet")
        return super().pilot(briefing)
