"""The lidar: the cells that a scan shows, by exact line of sight or by MarsExplorer's rays."""
