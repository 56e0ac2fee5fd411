"""Whether training on our objects helps on real ones: small networks, fixed seeds, one command each (see README.md)."""
