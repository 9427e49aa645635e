"""Localisation and mapping with sensors that err: noisy scans, pose drift and maps of log-odds."""
