"""The version of the package, which every data set names."""

__version__ = "0.3.0"
