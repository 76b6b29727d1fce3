"""The rivals, one a module."""
