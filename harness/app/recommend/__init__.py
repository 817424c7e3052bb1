"""Choice of a method, by what studies on labelled sets measured."""
