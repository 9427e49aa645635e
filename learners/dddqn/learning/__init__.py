"""Training: vectorised flight, replay, targets, the learner and its loop."""
