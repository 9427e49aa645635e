"""Generators of random maps."""
