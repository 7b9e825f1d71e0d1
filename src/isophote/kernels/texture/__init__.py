"""Textures: what they are given, and the kinds of them."""
