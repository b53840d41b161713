"""Wrench-space measures, planar and spatial: force closure, epsilon, volume, critical friction."""
