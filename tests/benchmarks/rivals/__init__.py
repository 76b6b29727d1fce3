"""Ways to learn reaching movements, ours among them, on the same recordings and the same scores."""
