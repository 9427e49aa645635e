"""Sampling-based exploration on OMPL."""
