"""Declared primitives to formulas of their patches and pieces; curves, and the solids that operators make of them."""
