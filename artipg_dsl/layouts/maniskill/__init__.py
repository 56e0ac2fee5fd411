"""The layout of ManiSkill: robots that open and turn things. ``files`` of objects and of the folder, ``check``."""
