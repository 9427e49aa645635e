"""What tables, charts and panels are made from: comparisons, times by task, sweeps, coverage axes."""
