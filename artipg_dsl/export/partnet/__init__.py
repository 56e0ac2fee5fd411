"""The folder of PartNet-Mobility. Begin with ``mobility``.

mobility        the files of objects
frame           the axes and the size of its objects
tree            the trees of parts
words           what it calls categories, links and joints
"""
