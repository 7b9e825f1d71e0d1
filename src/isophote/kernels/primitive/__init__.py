"""Shapes that rays meet by a formula: balls, planes, boxes, cylinders, cones, rings, quadrics, polygons."""
