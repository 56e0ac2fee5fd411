"""What is known of an object beyond its shape: labels of points, poses, grasps, the annotation as plain data."""
