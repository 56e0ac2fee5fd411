"""Pictures of objects and contact sheets, with OpenGL, ray casting or NumPy alone."""
