"""Stored episodes: the database, tables made from it, combined results, and ratios."""
