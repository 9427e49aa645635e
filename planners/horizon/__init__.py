"""Receding-horizon exploration: plan a tour, fly its first steps, and plan again when the map has grown."""
