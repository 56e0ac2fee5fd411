"""Everything about an object beyond its shape: labels of points, poses, grasps, views, the annotation as plain data.

In: a batch, with joint values unless it is shown at rest. Out: arrays with a row per object, and dictionaries that
JSON can hold. Begin with ``annotation`` (everything of an object) and ``cloud`` (everything of its points).

    annotation, rows                         an object as plain data, and as a line of text
    hierarchy, interactions                  what a handle belongs to; where to act, and in which direction
    cloud, sampling, shares, soup            points on the surface: how many for what, and the triangles they lie on
    points                                   labels and fields evaluated at points
    rebind                                   the same points on other objects of the program
    poses, frames, states, jacobian          where parts are, at rest and as joints move; how points move
    grasps, gripper                          grasps and keypoints; which of them a hand can make
    views, cameras, camera_file, seen        what cameras see, and the points that they see
"""
