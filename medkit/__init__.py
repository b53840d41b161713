"""medkit: a Jupyter-first research and teaching toolkit for robot grasping and handover.

The rooms, in the order of the walk of the data, are described in ``docs/architecture.md``.
Importing this package is light; every room loads its libraries when it is imported itself.
"""

__version__ = "0.1.0"
