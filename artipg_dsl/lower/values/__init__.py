"""What an expression of the text means while it is lowered, and how it is carried from frame to frame, table to table."""
