"""Pictures: one file for each method."""
