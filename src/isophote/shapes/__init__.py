"""What a thing is: descriptions of shapes, frozen and free of compiled code."""
