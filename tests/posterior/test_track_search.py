"""The search for a mode: turns are not lost, steps come to rest, biases are solved with caution."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import recordings
from probreg.errors import InvalidInputError
from probreg.noise import Gaussian
from probreg.posterior.tracks import _search, fit, fit_tracks, solve
from probreg.problems.recording import recording_problem
from probreg.recordings import setup_file
from probreg.registration import LawChoice
from probreg.registration._identities import of_some
from probreg.registration._track_model import track_model
from tests.independent import files
from tests.independent.cases import CASES
from tests.independent.simulate import simulate
from tests.posterior.traffic_tracks import draw, model_of


@pytest.fixture(scope="module")
def turning(tmp_path_factory):
    """Aircraft of which a third turn with 3 degrees a second, every report of its own target."""
    folder = tmp_path_factory.mktemp("turning")
    scene = CASES["easy"]()
    simulated = simulate(scene, np.random.default_rng([7, 11]))
    files.write(simulated, folder)
    setup = setup_file.read(folder / "sensors.toml")
    read = recordings.read(folder / "reports.csv", setup)
    problem = recording_problem(read.recording, read.setup)
    truth = np.array([simulated.truth.bias[name] for name in problem.names])
    return track_model(problem, LawChoice.usual(Gaussian())), truth


def test_turns_are_not_refused_whatever_the_first_targets_do(turning):
    model, truth = turning
    some = of_some(model, 4_000)
    near = fit_tracks(some)
    assert near.point.q < 0.1 * model.acceleration  # the search must not start from this
    found = fit_tracks(model, near=near)
    assert (found.wrong > 0.5).sum() == 0
    away = found.theta - truth
    # chi-square of eight biases, a false alarm in ten thousand
    assert away @ np.linalg.solve(found.covariance, away) < 31.8


def test_from_nine_times_what_straight_targets_have_turns_are_lost_for_ever(turning, monkeypatch):
    """The control: a report refused once is refused by the straight path that it leaves."""
    model, near_of = turning[0], fit._near
    near = fit_tracks(of_some(model, 4_000))
    monkeypatch.setattr(
        fit, "_near", lambda *given: dataclasses.replace(near_of(*given), livelier=9.0)
    )
    found = fit_tracks(model, near=near)
    assert (found.wrong > 0.5).sum() > 50


def test_biases_are_solved_for_under_more_acceleration_with_caution():
    model, _ = model_of(*draw(1, reports=800)[:2], caution=4.0)
    point = fit_tracks(model).point
    wanted = solve(model, dataclasses.replace(point, q=4.0 * point.q), 1.0)
    found = solve(model, point)
    np.testing.assert_array_equal(found.theta, wanted.theta)
    np.testing.assert_array_equal(found.covariance, wanted.covariance)
    assert (np.diag(found.covariance) > np.diag(solve(model, point, 1.0).covariance)).all()


@pytest.mark.parametrize("caution", [0.5, np.inf, np.nan])
def test_caution_below_one_is_refused(caution):
    with pytest.raises(InvalidInputError, match="caution"):
        model_of(*draw(1, reports=100)[:2], caution=caution)


@pytest.mark.parametrize("halved", [True, False])
def test_steps_that_swing_go_half_way_and_come_to_rest(halved, monkeypatch):
    """A step that answers every weight with one minus it, and biases that follow the weights."""
    model, _ = model_of(*draw(1, reports=200)[:2])
    fitted = fit_tracks(model)
    start = dataclasses.replace(fitted.point, weights=np.full(len(fitted.point.weights), 0.9))
    known = _search.step(model, start)

    def swings(model, point, widened=1.0, known_solution=None):
        theta = known.solution.theta + point.weights[0] * fitted.sd
        after = dataclasses.replace(point, weights=1.0 - point.weights)
        return known._replace(
            point=after, before=point, solution=known.solution._replace(theta=theta)
        )

    monkeypatch.setattr(_search, "step", swings)
    if not halved:
        monkeypatch.setattr(_search, "FULL_STEPS", _search.MOST_STEPS)
    found = _search.rest(model, start, known.solution.theta, 0.02)
    assert found.settled == halved
    if halved:
        np.testing.assert_allclose(found.point.weights, 0.5, atol=0.02)
