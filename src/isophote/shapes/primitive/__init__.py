"""Shapes that rays meet by a formula."""
