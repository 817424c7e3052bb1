"""Balance of forces, friction and first motion of what is loaded."""
