"""One flight: what was said of it, in words, figures and a page."""
