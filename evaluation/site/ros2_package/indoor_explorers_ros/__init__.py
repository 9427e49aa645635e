"""The explorer as a ROS 2 node."""
