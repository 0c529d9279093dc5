"""Simulated flights: plain, open loop and without input or output."""
