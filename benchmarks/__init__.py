"""Benchmarks: speed as ratios against rivals in the same run."""
