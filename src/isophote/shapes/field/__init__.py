"""Signed distance fields: expressions kept as data."""
