"""Every format read back by what reads it, in one shape, and compared with our model."""
