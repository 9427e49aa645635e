"""Coordination: how the UAVs of a team share the frontier under limited radio."""
