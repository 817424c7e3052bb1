"""Methods compared on layouts or on labelled cases: agreement, accuracy and cost."""
