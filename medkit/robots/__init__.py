"""Hands as kinematic trees with geometry; the only importer of pinocchio and coal."""
