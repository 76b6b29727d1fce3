"""The counterparts of the paper's figures."""
