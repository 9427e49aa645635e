"""Where a UAV is when its pose drifts: its path estimated again from what its own scans and loop closures say."""
