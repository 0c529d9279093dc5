"""What the monitor says of four fixed replays, kept to show every change of it."""
