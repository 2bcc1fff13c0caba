"""Simulated scenes, one a module: `simulate(...) -> (data, truth)`."""
