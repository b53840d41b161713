"""Outlines, their exact medial axis, antipodal pairs, and the pymunk squeeze."""
