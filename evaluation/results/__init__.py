"""Stored episodes: the database, tables made from it, combinations and ratios."""
