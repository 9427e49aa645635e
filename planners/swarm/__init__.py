"""Swarm-based exploration."""
