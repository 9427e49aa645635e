"""Learning of the DDDQN: vectorised flight, replay, targets and updates."""
