"""Faults injected into the running monitor, and how soon it says so."""
