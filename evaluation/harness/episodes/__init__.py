"""One episode: flying, recording, simulating again, metrics and lower bounds."""
