"""The layout of NPCS and ANCSH: part poses part by part. ``files`` of objects and of the folder, ``check``."""
