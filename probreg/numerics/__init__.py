"""Compiled kernels and small linear algebra that no other library has in this form."""
