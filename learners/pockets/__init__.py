"""Training of the pocket network: how much unknown free space is behind a frontier cluster."""
