"""When the hand is widest in grasps, beside the palm's transport.

Run: .venv/bin/python -m tests.benchmarks.aperture [CONTROLLER.npz]

For the script and for a controller, nominal runs of all tasks: from the glove's readings, the
distance of thumb tip to index tip. Counted are tasks in which it grows by more than `OPENS`
before it falls: things that are thin, and hands that rest more open than they need, are closed
from the start, by the script as well.
"""

import sys
from pathlib import Path

import numpy as np

from handsim.cli.defaults import planning_grasper
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.demonstrator import demonstrate, scripted_plan
from handsim.grasping.planning.grasper import Grasper
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.kinematics import Kinematics
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task

OPENS = 0.003
"""Growth of the aperture that counts as opening [m]."""
USUAL = Conditions(seed=5001)
HAND = Kinematics()


def widest(grasp: Grasper, task: Task, arrive: float) -> tuple[float, float, float]:
    """Return when the hand is widest as a share of the transport, and by how much it opens and
    closes [m]."""
    run, reach = grasp(task, USUAL), schedule_for(task).reach
    coming = run.time <= reach
    aperture = HAND.aperture(run.reading[coming])
    at = int(aperture.argmax())
    most = float(aperture[at])
    share = float(run.time[at]) / (arrive * reach)
    return share, most - float(aperture[0]), most - float(aperture[-1])


def main() -> None:
    grasper = planning_grasper(Path(sys.argv[1]) if sys.argv[1:] else None, USUAL)
    hand = HandModel.from_spec(build_hand(USUAL.hand))
    for name, grasp in (("script", demonstrate), ("controller", grasper)):
        rows = []
        for task in TASKS:
            if name == "script":
                plan = scripted_plan(task, hand)[0]
            else:
                plan = grasper.plan_for(task, Scene.build(task, USUAL))
            share, opens, closes = widest(grasp, task, plan.arrive)
            rows.append((share, opens, closes))
            said = f"widest at {share:.2f} of the transport, opens by {1e3 * opens:.0f} mm"
            print(f"{name} {task.name}: {said}, closes by {1e3 * closes:.0f} mm", flush=True)
        opening = np.array([row for row in rows if row[1] > OPENS])
        share, opens, _ = np.median(opening, axis=0)
        print(
            f"{name}: {len(opening)} of {len(rows)} open by more than {1e3 * OPENS:g} mm, in the "
            f"median by {1e3 * opens:.0f} mm and widest at {share:.2f} of the transport\n"
        )


if __name__ == "__main__":
    main()
