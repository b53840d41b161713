"""Recordings to human grasps to measures to a ranking; takes fingertip arrays, knows no planner."""
