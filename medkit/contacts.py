"""Contacts (points, inward normals, friction) to cones to wrenches."""
