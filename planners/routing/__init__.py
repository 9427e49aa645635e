"""Routing: in which order to visit places, and which UAV visits which."""
