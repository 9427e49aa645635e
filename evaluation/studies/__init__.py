"""Commands that build on comparisons: benchmarks, ablations, the thesis, leaderboards, maps, trainings."""
