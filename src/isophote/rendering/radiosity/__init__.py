"""Radiosity: light between diffuse surfaces, solved on patches."""
