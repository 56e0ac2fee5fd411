"""Arrays for training loops: batches of fresh or stored objects, for a task, augmented. NumPy alone.

In: categories, or folders that ``apgc sample`` has written. Out: one dictionary of arrays per batch, by the same names either way.
Begin with ``stream``; ``artipg_dsl.torch`` wraps both sources for PyTorch's DataLoader.

    tasks        what each task's arrays are, and how they are made of a batch of objects
    stream       batches of objects made on the way: which objects are in which batch of which epoch
    classes      classes of one's own instead of the words of a vocabulary
    stored       batches of objects that lie in folders
    transforms   augmentations of batches: turns, noise, occlusion, one-sided views
    draws        random numbers by the address of an object, for transforms
"""

from .stored import Stored
from .stream import Stream
from .tasks import TASKS
from .transforms import Drop, Jitter, Normalise, Occlude, Scale, Turn, View

__all__ = ["TASKS", "Drop", "Jitter", "Normalise", "Occlude", "Scale", "Stored", "Stream", "Turn", "View"]
