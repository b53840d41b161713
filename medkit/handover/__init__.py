"""Rating trials to scores to ordinal models to a release force."""
