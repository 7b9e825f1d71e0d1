"""Rays against single shapes, over arrays, in double precision."""
