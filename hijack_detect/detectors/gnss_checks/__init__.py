"""Consistency checks of a receiver stream, one idea a file: each takes steps, returns findings."""
