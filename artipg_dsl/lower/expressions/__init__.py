"""Expressions of the text to values (``lower.values``), in the frame and the table of an environment."""
