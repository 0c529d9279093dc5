"""The durable store and the black box: files written in flight, without ROS."""
