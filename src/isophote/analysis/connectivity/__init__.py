"""What is connected how in a mesh: stars, half-edges, components, boundary loops, orientation."""
