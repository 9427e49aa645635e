"""Flights in the simulators of other groups, each run from a clone of its repository in a process of its own."""
