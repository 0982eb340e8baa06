"""The commands of ros2 run evodevo_sim."""
