"""Pictures of objects and contact sheets, with OpenGL, ray casting or NumPy alone.

In: a batch and joint values. Out: images as arrays, and PNG files. Begin with ``sheet``.

    sheet, png                                many objects in one picture, written to a file
    scene, camera, regions                    triangles with their colours; the point of view; where to act
    raster_gl, raster_rays, raster_cpu        the renderers
    deferred                                  shading for renderers without a graphics library
"""
