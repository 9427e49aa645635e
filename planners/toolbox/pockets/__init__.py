"""Pockets: the unknown free space behind frontier clusters, and how much of it to expect before it is seen."""
