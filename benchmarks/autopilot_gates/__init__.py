"""What the innovation gates of PX4 and ArduPilot make of a spoofed GPS."""
