"""Attacks on GPS: scenario files, and the spoofer that applies them to a stream of samples."""
