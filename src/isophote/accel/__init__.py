"""Trees over shapes, for every room that asks where: built from arrays, on all cores."""
