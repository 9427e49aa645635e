"""Rows of results that others flew: read from their files, kept in a results folder, shown beside flown ones."""
