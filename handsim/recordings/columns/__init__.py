"""What the columns of a table are: numbers, clocks, names of joints, and the map of them."""
