"""handsim: human-like grasping learned from recordings, simulated in MuJoCo."""
