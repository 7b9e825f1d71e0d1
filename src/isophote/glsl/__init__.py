"""Shader files, under the same names as the kernels that they mirror."""
