"""Methods on families of layouts outside the distribution of the labelled sets."""
