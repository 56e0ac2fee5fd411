"""Objects as files: one model of a robot, one file per format, shards and manifests that appear whole or not at all."""
