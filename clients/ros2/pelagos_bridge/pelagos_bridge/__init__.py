"""Pelagos and ROS 2: mapping.py has the messages, node.py the node."""
