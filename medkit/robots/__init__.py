"""Hands as kinematic trees with convex bodies; the only importer of pinocchio and coal."""

from medkit.robots.hand import Finger, Hand, LinkBody, Opposition
from medkit.robots.library import hand_names, load_hand
from medkit.robots.tree import KinematicTree

__all__ = ["Finger", "Hand", "KinematicTree", "LinkBody", "Opposition", "hand_names", "load_hand"]
