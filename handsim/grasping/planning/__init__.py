"""Where palm and fingers go: the demonstrator's script, and plans for a learned controller.

In: a task, a hand and a controller. Out: a `GraspPlan`, searched in physics and kept on disk. May
import `grasping.rollout`.
"""
