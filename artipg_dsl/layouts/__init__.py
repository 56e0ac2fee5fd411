"""Folders as the field's training code reads them, unchanged: points, poses and joints under the names and numbers of others.

In: batches, and what they are called in another vocabulary. Out: bytes by path for objects that are made together, indices of
the whole folder, and what a folder read back does not hold as it should. Begin with ``registry``, which lists the layouts.

    registry, entry                     the layouts; what a folder holds of one category
    words                               what others call a category and its parts, and whether they have it at all
    clouds, pieces, pictures            points in the axes, sizes and classes of others; meshes and words of links; pixels of cameras
    shapenetpart, partnet               layouts for part segmentation
    gapartnet, ancsh                    layouts for part poses, in whole views and part by part
    cage, ditto                         layouts for kinematics, by trees and by two states
    opd                                 a layout for parts that open, seen from one side
    completion                          layouts for completion
    maniskill                           a layout for robots that open and turn things
    where2act                           a layout for trials of a hand
    hdf5, pcd, ply, pth                 files
    findings                            faults that a reader finds
"""
