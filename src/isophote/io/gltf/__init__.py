"""glTF 2.0 and GLB, reading and writing. Source: Khronos, glTF 2.0 specification."""
