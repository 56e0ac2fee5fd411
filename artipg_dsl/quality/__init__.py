"""How good a category is, in figures: what `apgc report` tells. Each file computes one of them from a batch of samples."""
