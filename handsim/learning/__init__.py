"""What is learned from recordings: the subspace, the obstacle, the controller."""
