"""What the network sees of a UAV's view: map image, view gains, candidates, tours."""
