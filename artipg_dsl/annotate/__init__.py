"""What is known of an object beyond its shape: labels of points, poses, grasps, views, the annotation as plain data.

In: a batch, with joint values where it is not to be shown at rest. Out: arrays with a row per object, and dictionaries that
JSON can hold. Begin with ``annotation`` (everything of an object) and ``cloud`` (everything of its points).

    annotation, hierarchy, interactions      an object as plain data; whose handle it is; where and which way one acts
    cloud, sampling, shares, soup            points on the surface: how many of what, and the triangles behind them
    points                                   labels and fields evaluated at points
    rebind                                   the same points on other objects of the program
    poses, frames, states, jacobian          where parts are, at rest and as joints move; how points move
    grasps, gripper                          grasps and keypoints; which of them a hand can make
    views, cameras, camera_file, seen        what cameras see, and what is known of the points that they see
"""
