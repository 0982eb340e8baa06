"""The nodes: thin shells of ROS around the library."""
