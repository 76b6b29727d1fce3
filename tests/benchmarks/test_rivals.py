"""The rivals of the learner: each on a small set whose answer is known, and how they are scored."""

import pickle
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from sklearn.mixture import GaussianMixture

sys.path.insert(0, str(Path(__file__).parent))
from rivals.__main__ import main
from rivals.data import Space, Trial, TrialSet, read_sets
from rivals.methods.any_data import AnyData
from rivals.methods.kernel_mean import KernelMean
from rivals.methods.lpv_ds import LinearParameterVarying, LinearSystems, Model, fitted
from rivals.methods.navigation import OurController, PaperField
from rivals.methods.path_process import KNOWN, UNKNOWN, PathProcess
from rivals.methods.primitive import MovementPrimitive
from rivals.methods.regression import MixtureRegression, samples
from rivals.methods.straight import StraightLine
from rivals.mixture import Mixture
from rivals.protocol import Motion, Movement, Query, timed
from rivals.registry import RIVALS, VARIANTS
from rivals.running import in_training, left_out, random_arrivals, run
from rivals.scoring import arrives, correlation, score

from handsim.errors import FileError
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.guide.predictor import GuideSettings
from handsim.learning.learn import learn_controller
from handsim.learning.movement.progress import minimum_jerk
from handsim.learning.scores import evaluate
from handsim.navigation.paths import arc_length
from handsim.recordings.folder import write_recordings
from handsim.recordings.importers.import_files import import_recordings

DATA = Path(__file__).parents[2] / "../shared/data"
REAL = DATA / "reach_to_grasp"


def bent(side: float, end: tuple[float, float], start: tuple[float, float], slow: float) -> Trial:
    """A path in the plane, bent to one side, of which ``slow`` of the time passes before it."""
    time = np.linspace(0.0, 1.5, 90)
    s = minimum_jerk(np.clip(time - 1.5 * slow, 0.0, None), 1.5 * (1.0 - slow))[:, None]
    away = np.array(end) - np.array(start)
    normal = np.array([-away[1], away[0]])
    path = np.array(start) + s * away + side * np.sin(np.pi * s) * normal
    return Trial("left" if side > 0 else "right", time, path)


@pytest.fixture(scope="module")
def trials() -> TrialSet:
    """Two objects in nearly one place, reached for with paths that are bent to either side."""
    rng = np.random.default_rng(0)
    made = []
    for side, end in ((0.4, (1.4, 0.1)), (-0.4, (1.4, -0.1))):
        for _ in range(4):
            start = tuple(0.05 * rng.normal(size=2))
            made.append(bent(side, end, start, 0.3))
    return TrialSet("made-up", tuple(made), None, "mm", 10.0)


def query(trials: TrialSet, i: int) -> Query:
    trial = trials.trials[i]
    return Query(trial.q[0], trial.q[-1], trial.object, float(trial.time[-1]))


def movements(trials: TrialSet) -> list[Movement]:
    return [Space(None).movement(trial) for trial in trials.trials]


def test_a_straight_line_is_the_yardstick(trials: TrialSet) -> None:
    found = run(StraightLine, trials, in_training(8))
    assert found.ratio == pytest.approx(1.0, abs=1e-12)
    # The root mean square of 0.4 |away| sin(pi s) over s is 0.4 / sqrt(2) of the length.
    assert found.mean("error") == pytest.approx(0.4 * 1.4 / 2**0.5, rel=0.05)
    assert found.arrived == found.proven == 8
    assert random_arrivals(StraightLine, trials, 30) == 30


def test_paths_of_the_same_object_say_what_the_next_one_is(trials: TrialSet) -> None:
    folds = left_out(8, 8)
    ratios = {
        name: run(make, trials, folds).ratio
        for name, make in (
            ("mean", KernelMean),
            ("mean, object known", lambda: KernelMean(across=0.0)),
            ("process", lambda: PathProcess(UNKNOWN)),
            ("process, object known", lambda: PathProcess(KNOWN)),
            ("primitive, object known", lambda: MovementPrimitive(by_object=True)),
        )
    }
    assert ratios["mean, object known"] < 0.03
    assert ratios["process, object known"] < 0.3
    assert ratios["primitive, object known"] < 0.08
    # Without the object both sides count about alike, which comes to the straight line.
    assert 0.8 < ratios["mean"] < 1.2
    assert 0.7 < ratios["process"] < 1.2


def test_who_waits_is_predicted_to_wait(trials: TrialSet) -> None:
    for make in (KernelMean, lambda: PathProcess(KNOWN)):
        motion = make().fit(movements(trials)).predict(query(trials, 0))
        moved = np.linalg.norm(motion.path - motion.path[0], axis=1)
        assert motion.time[moved < 0.01].max() == pytest.approx(0.3 * 1.5 + 0.09, abs=0.06)
        assert motion.time[-1] == pytest.approx(1.5)
    straight = run(StraightLine, trials, in_training(8))
    mean = run(lambda: KernelMean(across=0.0), trials, in_training(8))
    assert straight.mean("speed_correlation") < 0.7
    assert mean.mean("speed_correlation") > 0.98
    assert mean.mean("rms") < 0.1 * straight.mean("rms")


def test_a_primitive_reproduces_its_trial_and_goes_where_it_is_asked(trials: TrialSet) -> None:
    found = run(lambda: MovementPrimitive(by_object=False), trials, in_training(8))
    assert found.ratio < 0.1
    assert found.arrived == 8
    primitive = MovementPrimitive(by_object=True).fit(movements(trials))
    asked = Query(np.zeros(2), np.array([1.2, 0.3]), "left", 3.0)
    motion = primitive.predict(asked)
    assert motion.time[-1] == pytest.approx(3.0)
    assert np.linalg.norm(motion.path[-1] - asked.goal) < 0.02
    assert motion.path[:, 1].max() > 0.5  # bent to the left
    away = primitive.predict(Query(np.zeros(2), np.array([1.2, 0.3]), "right", 3.0))
    assert away.path[:, 1].min() < -0.2


def test_regression_has_no_reason_to_arrive(trials: TrialSet) -> None:
    places, directions = samples(movements(trials))
    field = MixtureRegression().fit(movements(trials)).field("")
    made = field(*np.split(places, 2, axis=1))
    cosines = np.sum(made * directions, axis=1) / np.linalg.norm(made, axis=1)
    assert cosines.mean() > 0.95  # it knows the way on the recordings
    assert run(MixtureRegression, trials, in_training(8)).proven == 0
    assert random_arrivals(MixtureRegression, trials, 20) < 10


def test_shares_of_a_mixture_are_those_of_scikit_learn() -> None:
    x = np.random.default_rng(0).normal(size=(60, 3))
    x[:30] += 2.0
    model = GaussianMixture(2, reg_covar=1e-3, random_state=0).fit(x)
    np.testing.assert_allclose(Mixture.of(x, 2, 1e-3).shares(x), model.predict_proba(x), atol=1e-9)
    first = Mixture.of(x, 2, 1e-3).over(slice(2))
    assert first.means.shape == (2, 2) and first.covariances.shape == (2, 2, 2)


def spiral(angle: float) -> Movement:
    """Exactly x' = A x with A = [[-1, -2], [2, -1]]."""
    time = np.linspace(0.0, 4.0, 400)
    decay = np.exp(-time)[:, None]
    turned = np.column_stack([np.cos(2 * time + angle), np.sin(2 * time + angle)])
    return Movement("it", decay * turned, time)


def test_linear_systems_find_a_linear_system() -> None:
    system = fitted([spiral(angle) for angle in (0.0, 2.0, 4.0)])
    x = np.random.default_rng(1).normal(size=(50, 2)) * 0.4
    # Destinations are ends of recordings, exp(-4) from the true one.
    np.testing.assert_allclose(system(x), x @ np.array([[-1.0, 2.0], [-2.0, -1.0]]), atol=0.15)
    assert system.is_stable


def test_a_system_that_grows_is_not_proven_stable() -> None:
    mixture = Mixture(np.ones(1), np.zeros((1, 2)), np.eye(2)[None])
    for real, stable in ((-0.1, True), (0.1, False)):
        matrices = np.array([[[real, -2.0], [2.0, real]]])
        assert LinearSystems(mixture, matrices, np.eye(2)).is_stable is stable
    assert not LinearSystems(mixture, np.eye(2)[None], -np.eye(2)).is_stable  # x'Px is negative
    shear = np.array([[[-1.0, 4.0], [0.0, -1.0]]])  # stable, but |x| may grow
    assert not LinearSystems(mixture, shear, np.eye(2)).is_stable
    assert LinearSystems(mixture, shear, np.diag([1.0, 9.0])).is_stable


def test_the_gradient_of_linear_systems_is_that_of_their_cost() -> None:
    rng = np.random.default_rng(0)
    x, v, shares = rng.normal(size=(40, 3)), rng.normal(size=(40, 3)), rng.random((40, 2))
    model = Model(x, v, shares / shares.sum(axis=1, keepdims=True))
    at = model.start() + 0.3 * rng.normal(size=len(model.start()))
    cost, gradient = model.cost(at)
    matrices, metric = model.matrices(at)
    made = np.einsum("nk,kij,nj->ni", shares / shares.sum(axis=1, keepdims=True), matrices, x)
    assert cost == pytest.approx(np.mean(np.sum((made - v) ** 2, axis=1)))
    assert np.linalg.eigvalsh(metric).min() > 0.0
    for i in range(len(at)):
        step = np.zeros(len(at))
        step[i] = 1e-6
        slope = (model.cost(at + step)[0] - model.cost(at - step)[0]) / 2e-6
        assert gradient[i] == pytest.approx(slope, rel=1e-4, abs=1e-7)


def test_linear_systems_of_each_object_bend_to_its_side(trials: TrialSet) -> None:
    whole = run(lambda: LinearParameterVarying(by_object=False), trials, in_training(8))
    apart = run(lambda: LinearParameterVarying(by_object=True), trials, in_training(8))
    assert apart.ratio < 0.6 < whole.ratio
    assert whole.arrived == whole.proven == apart.arrived == apart.proven == 8
    assert random_arrivals(partial(LinearParameterVarying, by_object=False), trials, 30) == 30


def test_the_paper_learns_one_object(trials: TrialSet) -> None:
    left = TrialSet("left", trials.trials[:2], None, "mm", 10.0)
    found = run(PaperField, left, in_training(2))
    assert found.ratio < 0.6
    assert found.arrived == 2
    rival = PaperField().fit(movements(left))
    motion = rival.predict(query(left, 0))
    speed = np.diff(arc_length(motion.path)) / np.diff(motion.time)
    slope = rival.speeds(motion.path, query(left, 0))
    # Its own speeds, but for a factor: minimum jerk would begin at rest.
    np.testing.assert_allclose(speed[:90] / speed[0], slope[:90] / slope[0], rtol=0.1)


@pytest.mark.parametrize("guided", [False, True])
def test_ours_are_scored_as_by_evaluate(recordings, guided: bool) -> None:
    made = tuple(Trial(r.object, r.time, r.q) for r in recordings)
    trials = TrialSet("made-up", made, 2, "deg", 180 / np.pi)
    quick = partial(DirectionLearner, certified=True, n_refinements=1, n_iterations=30)
    guide = GuideSettings() if guided else None
    found = run(partial(OurController, quick, guide, guided), trials, in_training(9))
    chosen = True if guided else None  # as the rival's guide is
    learned = learn_controller(recordings, 2, quick(), guided=guided, by_progress=chosen)
    controller = learned.controller
    known = evaluate(controller, recordings, object_known=guided)
    assert known.ratio is not None and known.ratio < 0.7
    assert found.ratio == pytest.approx(known.ratio, rel=1e-9)
    assert (found.arrived, found.proven) == (known.n_arrived, known.n_proven) == (9, 9)
    assert found.mean("rms") == pytest.approx(known.rms_over_time_deg, rel=0.02)
    assert found.mean("floor") == pytest.approx(known.rms_truncation_deg, rel=1e-9)
    assert found.mean("speed_correlation") == pytest.approx(known.speed_correlation, abs=0.02)


def test_paths_of_any_data_are_led_to_their_destination_by_proof(trials: TrialSet) -> None:
    left = tuple(Trial(t.object, t.time, t.q - t.q[-1]) for t in trials.trials[:3])
    one = TrialSet("left", left, None, "mm", 10.0)
    found = run(partial(AnyData, n_refinements=1), one, in_training(3))
    assert found.ratio < 0.2
    assert found.arrived == found.proven == 3
    rival = AnyData(n_refinements=0).fit(movements(one))
    far = Query(np.zeros(2), np.array([90.0, 0.0]), "left", 2.0)
    assert not arrives(rival.predict(far), far.goal)


def test_modes_that_share_a_fit_are_charged_for_it(trials: TrialSet) -> None:
    quick = partial(DirectionLearner, n_refinements=1, n_iterations=11)
    first = OurController(quick).fit(movements(trials))
    again = OurController(quick, GuideSettings()).fit(movements(trials))
    assert again.controller.navigation is first.controller.navigation
    assert first.saved == 0.0 and again.saved > 0.01
    fewer = OurController(quick).fit(movements(trials)[1:])
    assert fewer.saved == 0.0
    assert OurController(partial(quick, seed=1)).fit(movements(trials)).saved == 0.0


def test_a_destination_that_is_refused_counts_as_missed(trials: TrialSet) -> None:
    quick = partial(DirectionLearner, n_refinements=0, n_iterations=5)
    for guide in (None, GuideSettings()):
        rival = OurController(quick, guide).fit(movements(trials))
        asked = Query(np.zeros(2), np.array([90.0, 0.0]), "left", 2.0)
        assert not arrives(rival.predict(asked), asked.goal)
        assert not rival.proves(asked)


def test_each_trial_is_scored_once_and_never_learned_from() -> None:
    for n, n_folds in ((20, 10), (7, 10), (25, 10), (8, 8)):
        folds = left_out(n, n_folds)
        assert len(folds) == min(n, n_folds)
        assert sorted(i for fold in folds for i in fold.scored) == list(range(n))
        assert all(sorted(fold.learned + fold.scored) == list(range(n)) for fold in folds)


def test_scores_by_hand() -> None:
    time = np.linspace(0.0, 2.0, 41)
    q = np.column_stack([time / 2.0, np.zeros(41)])
    trial, space = Trial("it", time + 5.0, q), Space(None)
    movement = space.movement(trial)
    beside = Motion(q + [0.0, 0.3], time)
    found = score(beside, trial, movement, space, 100.0, proven=True)
    assert found.error == pytest.approx(0.3)
    assert found.straight == pytest.approx(0.0, abs=1e-12)
    assert found.rms == pytest.approx(100.0 * 0.3 / 2**0.5)  # of two coordinates one is off
    assert found.floor == 0.0
    assert np.isnan(found.speed_correlation)  # neither speed varies
    assert found.proven and not found.arrived
    near = Motion(np.array([[0.0, 0.0], [1.0, np.deg2rad(3.9)]]), np.array([0.0, 2.0]))
    assert arrives(near, q[-1])
    assert not arrives(Motion(near.path * [1.0, 1.1], near.time), q[-1])
    late = Motion(q, np.append(time[:-1] / 2.0, 2.0))  # twice as fast, then waits at the end
    assert score(late, trial, movement, space, 1.0, proven=False).rms > 0.1


def test_correlation_by_hand() -> None:
    assert correlation(np.array([1.0, 2.0, 3.0]), np.array([3.0, 5.0, 7.0])) == pytest.approx(1.0)
    assert correlation(np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.0, 1.0])) == pytest.approx(0.0)


def test_a_path_is_passed_at_the_progress_that_is_asked_for() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    pause = np.interp(np.linspace(0, 1, 51), [0.0, 0.2, 0.6, 1.0], [0.0, 0.25, 0.25, 1.0])
    motion = timed(corner, 10.0, pause)
    assert motion.time[[0, -1]].tolist() == [0.0, 10.0]
    halves = np.column_stack([np.interp([2.0, 4.0, 6.0], motion.time, x) for x in motion.path.T])
    np.testing.assert_allclose(halves, [[0.5, 0.0]] * 3, atol=1e-12)
    assert arc_length(motion.path)[-1] == pytest.approx(2.0)  # the corner is not cut
    still = timed(np.zeros((3, 2)), 1.0)
    assert np.isfinite(still.path).all() and still.time[-1] == 1.0


def test_a_folder_has_a_set_for_each_person_and_a_file_one_of_handwriting(
    recordings, tmp_path: Path
) -> None:
    write_recordings(recordings[:4], tmp_path / "hands")
    (one,) = read_sets(tmp_path / "hands")
    assert (one.name, len(one.trials), one.unit) == ("made-up", 4, "deg")
    assert one.space(range(4)).movement(one.trials[0]).path.shape == (80, 3)
    writing = tmp_path / "writing"
    writing.mkdir()
    place = np.linspace([40.0, 0.0], [0.0, 0.0], 1000)
    np.savez(writing / "Line.npz", pos=np.array([place] * 2), t=np.array([np.arange(1000.0)] * 2))
    (line,) = read_sets(writing)
    assert (line.name, line.unit, len(line.trials[0].time)) == ("Line", "mm", 200)
    assert line.per_rad == pytest.approx(40.0 / 3**0.5, rel=1e-2)
    np.testing.assert_allclose(line.trials[0].q[[0, -1]] * line.per_rad, place[[0, -1]])
    np.savez(writing / "Line.npz", pos=np.zeros(3))
    for folder, why in ((writing, "give pos and t"), (tmp_path, "neither")):
        with pytest.raises(FileError, match=why):
            read_sets(folder)


def test_the_command_writes_a_table(recordings, tmp_path: Path, capsys) -> None:
    write_recordings(recordings, tmp_path / "hands")
    table, folder = tmp_path / "table.md", str(tmp_path / "hands")
    asked = ["-o", str(table), "--folds", "3", "--only", "straight", "process"]
    assert main([folder, *asked]) == 0
    lines = table.read_text(encoding="utf-8").splitlines()
    assert "Python" in lines[0] and "NumPy" in lines[0]
    assert "### hands: 9 movements" in lines
    header, _, straight, unknown, known = (line.split(" | ") for line in lines if "|" in line)
    assert header[:4] == ["| method", "path: training", "path: left out", "path: 3 folds"]
    assert {len(row) for row in (header, straight, unknown, known)} == {14}
    assert straight[:4] == ["| straight line", "1.000", "1.000", "1.000"]
    assert straight[8:12] == ["9", "9", "200", "9: the distance falls"]
    assert float(known[2]) < float(straight[2])
    assert main([folder, "--only", "nobody"]) == 2
    assert main([str(tmp_path), *asked]) == 2
    errors = [x for x in capsys.readouterr().err.splitlines() if x.startswith("error")]
    assert len(errors) == 2 and "nobody" in errors[0] and "experiments.csv" in errors[1]
    assert table.read_text(encoding="utf-8").splitlines() == lines


def test_what_was_found_is_kept_when_a_rival_fails(
    recordings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Broken(StraightLine):
        def fit(self, movements):
            raise ArithmeticError

    write_recordings(recordings[:3], tmp_path / "hands")
    monkeypatch.setattr("rivals.__main__.RIVALS", {"first": StraightLine, "second": Broken})
    with pytest.raises(ArithmeticError):
        main([str(tmp_path / "hands"), "-o", str(tmp_path / "table.md")])
    assert "| first | 1.000 |" in (tmp_path / "table.md").read_text(encoding="utf-8")


def test_rivals_go_to_other_processes() -> None:
    for rivals in (RIVALS, VARIANTS):
        for name, make in pickle.loads(pickle.dumps(rivals)).items():
            assert type(make()) is type(rivals[name]())
    assert isinstance(RIVALS["ours, guided"](), OurController)


@pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared")
@pytest.mark.real_data
def test_paths_of_a_person_left_out() -> None:
    files = [REAL / f"{letter}_R2G_SUBJECTbyOBJECT_raw.mat" for letter in "tX"]
    recordings = import_recordings(files, "west-rtg", 4)
    trials = TrialSet(
        "4", tuple(Trial(r.object, r.time, r.q) for r in recordings), 3, "deg", 180 / np.pi
    )
    folds = left_out(20, 20)
    assert run(RIVALS["kernel mean of paths"], trials, folds).ratio == pytest.approx(0.67, abs=0.02)
    known = run(RIVALS["process of paths, object known"], trials, folds)
    assert known.ratio == pytest.approx(0.468, abs=0.01)
    assert known.arrived == 20


@pytest.mark.skipif(not (DATA / "handwriting").is_dir(), reason="no handwriting in ../shared")
@pytest.mark.real_data
def test_handwriting_is_read() -> None:
    sets = read_sets(DATA / "handwriting")
    assert all(len(each.trials) >= 2 and each.unit == "mm" for each in sets)
    angle = next(each for each in sets if each.name == "Angle")
    assert run(StraightLine, angle, in_training(7)).ratio == pytest.approx(1.0, abs=1e-9)
    assert run(KernelMean, angle, left_out(7, 7)).ratio < 0.3
