"""Figures and tables, drawn from saved results only: `python -m paper_figs [NAME ...]`."""
