"""Frontier-based exploration."""
