"""Whole experiments: simulate a street with its truth, run the chain on it, and score the result.

`simulate` writes a scene, `score` compares a run folder with the truth, `demo` does both with a run between.
"""
