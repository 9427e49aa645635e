"""Searches on grids: breadth-first search, connected parts, frontiers, visibility, sets of cells."""
