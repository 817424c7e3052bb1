"""The product: the check of a load, the viewer, the choice of a method. It imports no study."""
