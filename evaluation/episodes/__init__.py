"""One episode: flying, recording, simulating it again, metrics and lower bounds."""
