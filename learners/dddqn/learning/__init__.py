"""Training of the DDDQN: vectorised flight, replay, targets, updates and the training loop."""
