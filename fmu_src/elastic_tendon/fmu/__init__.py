"""FMUs of a model: description, binary, packing."""
