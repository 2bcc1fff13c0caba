"""Studies of the papers and beyond: `python -m experiments list | run STUDY`."""
