"""Reading and writing of mcap bags."""
