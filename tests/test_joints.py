import numpy as np

from handsim import joints


def test_the_papers_count_of_joints():
    motions = [joint.motion for joint in joints.JOINTS]
    assert len(motions) == joints.N_JOINTS == 22
    fingers = [joint for joint in joints.JOINTS if joint.finger]
    assert sum(joint.motion == "flexion" for joint in fingers) == 14
    assert sum(joint.motion in ("abduction", "rotation") for joint in fingers) == 5
    assert motions.count("arch") == 1
    assert joints.JOINT_NAMES[-2:] == ("wrist_flexion", "wrist_deviation")


def test_clipping_keeps_what_is_inside():
    q = np.vstack([joints.LOWER - 0.1, joints.UPPER + 0.1, 0.5 * (joints.LOWER + joints.UPPER)])
    clipped = joints.clip_to_range(q)
    np.testing.assert_array_equal(clipped[0], joints.LOWER)
    np.testing.assert_array_equal(clipped[1], joints.UPPER)
    np.testing.assert_array_equal(clipped[2], q[2])
    assert np.all(joints.LOWER < joints.UPPER)
