"""Render a frame in a separate process and report on standard output whether it worked.

Run as a file, ``python -P probe.py BACKEND SECONDS``, so that nothing of handsim is imported and a
driver that aborts takes only this process with it. Prints one JSON object.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import json
import os
import sys
import time
from typing import Any

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="ellipsoid" size=".3 .2 .1" rgba=".9 .6 .5 1"/>
    <geom type="plane" size="2 2 .1" pos="0 0 -.2"/>
  </worldbody>
</mujoco>
"""
WIDTH, HEIGHT = 320, 240


def render(seconds: float) -> dict[str, object]:
    """Render for ``seconds``, one frame at least; return the driver and the frames a second."""
    import mujoco
    import numpy as np

    model = mujoco.MjModel.from_xml_string(SCENE)
    model.vis.quality.shadowsize = 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data)
        frame = renderer.render()
        if np.ptp(frame) == 0:
            raise RuntimeError("the frame it renders is blank")
        frames, start = 0, time.perf_counter()
        while time.perf_counter() - start < seconds:
            renderer.update_scene(data)
            renderer.render()
            frames += 1
        elapsed = time.perf_counter() - start
        driver = _driver()
    return {"driver": driver, "frames_per_second": frames / elapsed if frames else None}


def _driver() -> str:
    try:
        from OpenGL import GL

        name: Any = GL.glGetString(GL.GL_RENDERER)
    except Exception:  # PyOpenGL raises many classes, and the name is only for display
        return "unknown"
    return name.decode() if isinstance(name, bytes) else "unknown"


def main() -> None:
    """Probe the backend named by the first argument for the seconds given by the second."""
    backend, seconds = sys.argv[1], float(sys.argv[2])
    os.environ["MUJOCO_GL"] = backend
    os.environ.pop("PYOPENGL_PLATFORM", None)
    try:
        outcome = {"ok": True, **render(seconds)}
    except AttributeError:  # PyOpenGL looks up its functions in None when it finds no library
        outcome = {"ok": False, "reason": "its library is not installed"}
    except Exception as error:  # whatever goes wrong is the answer asked for
        text = str(error).strip().splitlines()
        outcome = {"ok": False, "reason": text[-1] if text else type(error).__name__}
    sys.stdout.write(json.dumps(outcome) + "\n")


if __name__ == "__main__":
    main()
