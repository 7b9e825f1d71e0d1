"""Why a pixel has its colour, as values, text and pictures."""
