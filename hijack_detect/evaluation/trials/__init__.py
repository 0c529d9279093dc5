"""Many flights to judge methods on, and running them on several cores."""
