"""Folders as the field's training code reads them, unchanged: points, poses and joints under the names and numbers of others.

In: batches, and what they are called in another vocabulary. Out: bytes by path for objects that are made together, indices of
the whole folder, and what a folder read back does not hold as it should. Begin with ``registry``, which lists the layouts.

    registry, entry                     the layouts; what a folder holds of one category
    words                               what others call a category and its parts, and whether they have it at all
    clouds, partnet_parts               points in the axes, sizes and classes of others; the trees of PartNet
    shapenetpart, partnet_seg           layouts for part segmentation
    gapartnet, gaparts                  a layout for part poses; parts that a hand can use, and their boxes
    gaviews, split_links, gaviews_check annotated folders and rendered views, for GAPartNet's tools
    ancsh, ancsh_check                  a layout for part poses part by part
    cage, ditto                         layouts for kinematics, by trees and by two states
    opd, opd_lists, opd_check           a layout for parts that open, seen from one side
    completion                          layouts for completion
    pieces, pictures                    meshes and words of an object's links; what cameras see of it, pixel by pixel
    maniskill, maniskill_check          a layout for robots that open and turn things
    where2act, where2act_check          a layout for trials of a hand
    hand, forecast, foretold            what comes of them, in SAPIEN and as annotations say
    scaled                              a robot in another unit of length
    outlines                            masks as polygons
    hdf5, pcd, ply, pth                 files
    findings                            faults that a reader finds
"""
