"""What planners and learners both compute from a map: frontiers, view gains, paths, tours, shares of a team.

Nothing here is a policy. Planners build on all of it; learners may import it too, but never a planner.
"""
