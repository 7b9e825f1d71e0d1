"""One representation each: how a triangle, say, is hit by a ray."""
