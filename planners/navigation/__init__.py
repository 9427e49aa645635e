"""How a UAV gets to a goal: paths, goal keeping, and what it does when a teammate is in the way."""
