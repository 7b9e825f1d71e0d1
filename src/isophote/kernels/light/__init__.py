"""How light leaves, scatters and is added up: emitters, BSDFs, textures, film."""
