"""Suites: fixed, versioned lists of tasks, with parts to train, validate and test on."""
