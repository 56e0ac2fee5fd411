"""The layout of PartNet: part segmentation by level and by instance. ``parts``, its trees; ``files`` of objects and of the folder."""
