"""Routing: the order of visits to places, and their assignment to UAVs."""
