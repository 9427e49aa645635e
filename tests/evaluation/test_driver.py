"""What a run tells of its progress."""

from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest


class Told:
    """A watcher that keeps what it is told."""

    def __init__(self):
        self.begun, self.count = None, 0

    def begin(self, total, missing):
        self.begun = total, missing

    def flown(self, records, seconds_left):
        self.count += len(records)


def test_tasks_that_were_not_asked_for_are_not_told_as_flown(tmp_path):
    request = ComparisonRequest.of(policies=["random"], scenario="thesis-open", episodes=5, workers=0)
    experiment, told = plan(request), []
    for only in (experiment.tasks()[:2], experiment.tasks()[:3], None):
        told.append(Told())
        fly_missing(experiment, tmp_path, request, watcher=told[-1], only=only)
    assert [(each.begun, each.count) for each in told] == [((2, 2), 2), ((3, 1), 1), ((5, 2), 2)]
