"""Surface, medial axis, grid, symmetry, candidates, closing, planners: one file a step."""
