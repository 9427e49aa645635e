"""Computations on maps that planners and learners share: frontiers, view gains, paths, tours, coordination.

Nothing here is a policy. Planners build on all of it; learners may import it too, but never a planner.
"""
