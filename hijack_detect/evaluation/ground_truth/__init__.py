"""What is known of a flight's attack from elsewhere, and whether an alert was right."""
