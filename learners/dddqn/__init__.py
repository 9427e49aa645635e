"""Dueling double deep Q-learning."""
