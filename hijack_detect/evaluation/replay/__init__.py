"""Bags in, messages or bags out: playback, injection, simulated bags."""
