"""Exploration as a POMDP: Monte-Carlo planning in completions of the map that are drawn from a learned prior."""
