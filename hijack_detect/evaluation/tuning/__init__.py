"""Thresholds from flights: noise, surveys, sweeps."""
