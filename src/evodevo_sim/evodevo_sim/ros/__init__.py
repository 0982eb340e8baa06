"""Messages, processes and command lines: from here on ROS may be imported."""
