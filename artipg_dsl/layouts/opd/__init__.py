"""The layout of OPD and OPDMulti: parts that open, seen from one side. ``files`` of objects, ``lists`` of the folder, ``check``."""
