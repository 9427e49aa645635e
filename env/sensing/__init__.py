"""The lidar: what a scan shows, by exact line of sight or by the ancestor's rays."""
