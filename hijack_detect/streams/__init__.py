"""Time-stamped samples, their validity checks and their merging into one ordered stream."""
