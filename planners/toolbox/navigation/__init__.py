"""Navigation: how a UAV keeps a goal, finds a path to it, and resolves deadlocks with teammates."""
