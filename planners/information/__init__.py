"""Where there is something to see: frontier clusters, view gains, candidate viewpoints."""
