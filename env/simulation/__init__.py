"""The simulator: state of a batch of episodes, their reset, step and radio."""
