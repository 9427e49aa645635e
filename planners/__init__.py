"""Classical planners: frontier-based, sampling-based and swarm."""
