"""Planners of other groups as policies, each run from a clone of its repository in a process of its own."""
