"""Descriptions into tables."""
