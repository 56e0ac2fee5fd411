"""The layouts of GAPartNet: part poses, and what its tools are given and make.

parts                               parts that a hand can use, and their boxes
points                              views with parts and normalised coordinates
views, views_check, split_links     annotated folders and rendered views
"""
