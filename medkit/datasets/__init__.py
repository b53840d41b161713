"""Objects, human grasps, handover trials: files with provenance and schema, no algorithms."""
