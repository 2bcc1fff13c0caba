"""A watch over the biases of sensors that never stops: slice by slice, in bounded memory."""
