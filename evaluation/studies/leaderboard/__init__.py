"""Leaderboards: one table for each scenario of a suite, made of result folders whose episodes are simulated again."""
