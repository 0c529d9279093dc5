"""The monitor as one object, its parameters, and its run over a bag without ROS."""
