"""Leaderboards: one table for each scenario of a suite, from result folders whose episodes are simulated again."""
