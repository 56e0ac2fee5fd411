"""The layout of Where2Act and Where2Explore: trials of a hand at points of an object.

files, check            files of objects and of the folder; these read back
hand, scaled            trials in SAPIEN; a robot in another unit of length
forecast, foretold      the same trials as annotations say they come out
"""
