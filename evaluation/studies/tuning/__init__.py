"""Searches for parameters of a policy: paired trials by Optuna, dropped early, and the gain on fresh seeds."""
