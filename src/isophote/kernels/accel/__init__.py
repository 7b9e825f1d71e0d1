"""Trees over boxes, and the chain that asks every kind of table for its nearest hit."""
