"""Engines, which fly episodes: worker processes of this machine, or a Ray cluster."""
