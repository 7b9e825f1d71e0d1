"""One rendering method each."""
