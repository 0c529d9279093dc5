"""How good each method was on many flights."""
