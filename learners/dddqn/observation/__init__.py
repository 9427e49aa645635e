"""The network's input from one UAV's view: map image, view gains, candidates, tours."""
