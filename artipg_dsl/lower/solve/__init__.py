"""Equations to explicit values and requirements to conditional ranges: which unknown yields to which statement."""
