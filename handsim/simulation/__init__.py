"""What happens: closed-loop grasps in contact physics, and their judgement."""
