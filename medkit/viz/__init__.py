"""Figures: plot_* with matplotlib (takes ax=, returns Axes), show_* in 3-D."""
