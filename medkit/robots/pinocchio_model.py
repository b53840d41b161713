"""A hand as pinocchio's model, for rooms that need its dynamics and derivatives."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from medkit.geometry import Floats
from medkit.robots.hand import Hand
from medkit.robots.tree import FIXED, REVOLUTE


def pinocchio_model(hand: Hand) -> pin.Model:
    """Build pinocchio's model of a hand, one joint per moving link, coupled ones included.

    Parameters
    ----------
    hand : Hand
        The hand.

    Returns
    -------
    pinocchio.Model
        Every link is a frame of its own name. Masses are not known and left at zero.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> pinocchio_model(load_hand("schunk")).nq  # 13 driven joints and 4 that follow
    17
    """
    model = pin.Model()
    model.name = hand.name
    tree = hand.tree
    joint_of: list[int] = []
    local: list[pin.SE3] = []
    for link, name in enumerate(hand.link_names):
        parent = int(tree.parent[link])
        placed = pin.SE3(tree.placement[link])
        carrier = joint_of[parent] if parent >= 0 else 0
        if parent >= 0:
            placed = local[parent] * placed
        if tree.kind[link] != FIXED:
            kind = (
                pin.JointModelRevoluteUnaligned
                if tree.kind[link] == REVOLUTE
                else pin.JointModelPrismaticUnaligned
            )
            carrier = model.addJoint(carrier, kind(*tree.axis[link]), placed, f"{name} joint")
            placed = pin.SE3.Identity()
        joint_of.append(carrier)
        local.append(placed)
        model.addFrame(pin.Frame(name, carrier, placed, pin.FrameType.BODY))
    return model


def pinocchio_configuration(hand: Hand, q: Floats) -> Floats:
    """Configuration of `pinocchio_model` at the joint coordinates `q` (nq,) [rad or m]."""
    tree = hand.tree
    moving = np.flatnonzero(tree.kind != FIXED)
    driver = np.maximum(tree.coordinate[moving], 0)
    drive = np.where(tree.coordinate[moving] >= 0, np.asarray(q)[driver], 0.0)
    return np.asarray(tree.multiplier[moving] * drive + tree.offset[moving])
