"""Episodes as they are drawn for others, who may have to learn from what they see."""

from handsim.exports.episode import Episode
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.posture_clips import posture_clip, posture_model


def bare_clip(episode: Episode) -> Clip:
    """Return an episode as a clip from 0 s on, with nothing drawn in that tells how it ends.

    Of a simulated grasp it is what was simulated, whatever the episode was resampled to.
    """
    rollout = episode.rollout
    if rollout is not None:
        return Clip(rollout.model(), rollout.time - rollout.time[0], rollout.qpos)
    joints = episode.quantity("joints")
    assert joints is not None  # every movement has them
    return posture_clip(episode.time - episode.time[0], joints.values, posture_model(episode.hand))
