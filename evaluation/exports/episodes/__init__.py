"""A recorded episode as a file for other programs: a ROS 2 bag, an MCAP file, or CSV."""
