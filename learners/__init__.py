"""Learned policies and their training."""
