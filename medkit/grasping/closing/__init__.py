"""The compiled inside of closing a hand: the hand and the object as tables, and the kernels.

Python callers are `grasping.power` and `grasping.precision`; nothing else needs to look in here.
"""
