"""Where episodes are flown: worker processes of this machine, or a Ray cluster."""
