"""A page with figures of one analysed flight."""
