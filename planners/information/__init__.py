"""Information gain: frontier clusters, view gains, candidates."""
