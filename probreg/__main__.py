"""`python -m probreg` is the command `probreg`."""

from probreg.cli import main

main()
