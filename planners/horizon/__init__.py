"""Receding-horizon exploration: whole tours planned ahead, flown step by step, planned anew as the map grows."""
