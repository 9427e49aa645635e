"""Experiments, requests, the selection of policies and scenarios, limits and provenance."""
