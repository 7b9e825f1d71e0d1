"""What every kernel stands on: decorators, SIMD vectors, 3D vectors, random numbers, sampling."""
