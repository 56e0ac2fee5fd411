"""What simulators make of exported objects, level by level. One adapter per simulator, one set of levels for all."""
