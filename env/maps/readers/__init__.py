"""Readers of map files."""
