"""One shape into another; the only place that knows two representations."""
