"""Compiled code: knows only numbers, records and tables."""
