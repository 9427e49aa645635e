"""Frontiers: the known free cells beside unknown ones, in clusters."""
