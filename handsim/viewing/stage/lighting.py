"""Lamps and backgrounds for pictures of hands alone, without a table or a room."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco

_Colour = tuple[float, float, float]

_SKY_TOP, _SKY_BOTTOM = (0.93, 0.95, 0.98), (0.78, 0.82, 0.87)
_PLAIN = (0.88, 0.90, 0.93)


def light_upright_hand(spec: mujoco.MjSpec) -> None:
    """Add a bright background and two lamps for the human hand with its fingers to +z."""
    _add_background(spec, _SKY_TOP, _SKY_BOTTOM)
    light = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spec.worldbody.add_light(
        type=light, dir=[-0.4, -0.5, -0.8], diffuse=[0.5] * 3, specular=[0.1] * 3
    )
    spec.worldbody.add_light(type=light, dir=[0.2, 0.9, -0.1], diffuse=[0.25] * 3, specular=[0] * 3)
    spec.visual.headlight.ambient = [0.35] * 3
    spec.visual.headlight.diffuse = [0.35] * 3
    spec.visual.headlight.specular = [0.05] * 3


def light_from_the_camera(model: mujoco.MjModel) -> None:
    """Brighten an upright hand that is seen from where its two lamps do not reach, as the back."""
    model.vis.headlight.diffuse[:] = 0.5


def light_any_hand(spec: mujoco.MjSpec) -> None:
    """Add a plain background and even light, whatever lamps the model has of its own."""
    _add_background(spec, _PLAIN, _PLAIN)
    spec.visual.headlight.ambient = [0.45] * 3


def _add_background(spec: mujoco.MjSpec, top: _Colour, bottom: _Colour) -> None:
    spec.add_texture(
        name="handsim_background",  # a name that a user's model does not have
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=top,
        rgb2=bottom,
        width=256,
        height=256,
    )
