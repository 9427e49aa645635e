"""Exploration by robots that run ROS 2: the explorer, DDS, and simulated robots to try it on."""
