"""Statements to parts, poses, joints, links and labels: a category is taken apart into instances, from end to end."""
