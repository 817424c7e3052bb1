"""The environment keeps to Gymnasium's contract, and what it packs stands."""

import subprocess
import sys
import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import steadyload.gym
from steadyload.gym import OnlinePackingError
from steadyload.layouts import Item, Pallet
from steadyload.methods import make_method

NAME = "steadyload/OnlinePacking-v0"


def made(**how):
    return gymnasium.make(NAME, **how)


@pytest.mark.parametrize("how", [{}, {"method": "fbs", "item_class": 1, "cell": 2.5}])
def test_gymnasiums_own_checker_finds_nothing(how):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(made(**how).unwrapped)


def at_random(env, info, draw):
    return env.action_space.sample(mask=info["action_mask"])


def lowest(env, info, draw):
    """The lowest place, of these the nearest to the corner."""
    allowed = np.flatnonzero(env.unwrapped.action_masks())
    return allowed[env.unwrapped.resting_heights()[allowed].argmin()]


def episode(env, choose, seed):
    """Actions and rewards of an episode, and the last info."""
    _, info = env.reset(seed=seed)
    env.action_space.seed(seed)
    draw, ended, actions, rewards = np.random.default_rng(seed), False, [], []
    while not ended:
        assert info["action_mask"].any()
        actions.append(int(choose(env, info, draw)))
        seen, reward, ended, cut, info = env.step(actions[-1])
        rewards.append(reward)
        assert not cut
        assert seen in env.observation_space
    return actions, rewards, info


@pytest.mark.parametrize("choose", [at_random, lowest])
@pytest.mark.parametrize(("method", "packed"), [("equilibrium", 0.4), ("pbs0.7", 0.25)])
def test_an_episode_packs_a_bin_and_every_placement_stands(method, packed, choose):
    env = made(method=method)
    actions, rewards, info = episode(env, choose, seed=7)
    layout = env.unwrapped.layout()
    assert len(layout) == len(actions)
    # The score is 1 only if every step is stable.
    assert make_method(method).judge(layout).score == 1.0
    volume = sum(np.prod(item.size) for item in layout.items) / 100.0**3
    assert sum(rewards) == pytest.approx(volume) == pytest.approx(info["volume_share"])
    assert volume > (packed if choose is lowest else 0.1)
    assert info["reason"] == f"box {len(layout)} stands nowhere"
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.unwrapped.step(0)


def test_the_reference_says_of_an_episode_that_it_stands():
    env = made(box_count=20)
    episode(env, at_random, seed=3)
    assert make_method("label@mujoco").judge(env.unwrapped.layout()).score == 1.0


def test_the_mask_is_what_would_stand():
    env = made(box_count=12, cell=20.0).unwrapped
    _, info = env.reset(seed=1)
    for _ in range(8):
        mask = info["action_mask"]
        assert (mask == env.action_masks()).all()
        whole = make_method("equilibrium")
        for action in range(env.action_space.n):
            item = env.placement(action)
            with env.session.fork() as fork:
                try:
                    stands = fork.try_place(item).stable
                except steadyload.layouts.model.layout.LayoutError:
                    stands = False
                if stands:
                    assert whole.judge(fork.layout()).stable
            assert stands == mask[action]
        *_, info = env.step(int(np.flatnonzero(mask)[-1]))


def test_an_action_that_would_not_stand_ends_the_episode_and_places_nothing():
    env = made(cell=20.0)
    _, info = env.reset(seed=1)
    for _ in range(3):
        *_, info = env.step(int(np.argmax(info["action_mask"])))
    wrong = int(np.argmin(info["action_mask"]))
    seen, reward, ended, _, after = env.step(wrong)
    assert (reward, ended) == (0.0, True)
    assert after["reason"] == f"box 3 does not stand by action {wrong}"
    assert not after["action_mask"].any()
    assert not seen["box"].any()
    assert len(env.unwrapped.layout()) == 3
    assert after["volume_share"] == info["volume_share"]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.unwrapped.step(wrong)
    for action in (-1, 50, "here"):
        with pytest.raises(OnlinePackingError, match="allowed: 0 to 49"):
            env.unwrapped.step(action)


def test_a_seed_draws_the_same_episodes_and_another_others():
    one, other = made(), made()
    first = episode(one, at_random, seed=5)[:2]
    assert episode(other, at_random, seed=5)[:2] == first
    assert episode(other, at_random, seed=6)[:2] != first
    # Without a seed, the next boxes of the same sequence come.
    one.reset(seed=5), other.reset(seed=5)
    again = [env.reset()[0]["box"].tolist() for env in (one, other)]
    assert again[0] == again[1] != one.reset(seed=5)[0]["box"].tolist()


def test_given_boxes_come_in_their_order_and_turn_with_their_centres_of_mass():
    pallet = Pallet(100.0, 60.0, 40.0)
    boxes = [
        Item(9, (3.0, 3.0, 3.0), (100.0, 20.0, 40.0), 5.0, name="board"),
        Item(9, (0.0, 0.0, 0.0), (40.0, 20.0, 30.0), 2.0, (20.0, 0.0, -3.0)),
    ]
    env = made(pallet=pallet, boxes=boxes, cell=10.0).unwrapped
    seen, _ = env.reset()
    assert seen["heights"].shape == (10, 4)
    assert seen["box"].tolist() == [100.0, 20.0, 40.0, 5.0, 0.0, 0.0, 0.0]
    seen, reward, *_ = env.step(0)
    assert reward == pytest.approx(1 / 3)
    assert (seen["heights"] == 20.0).all()
    assert seen["box"].tolist() == [40.0, 20.0, 30.0, 2.0, 20.0, 0.0, -3.0]
    # Turned: 30 along x and 40 along z. It overhangs where its centre of mass is still above.
    *_, ended, _, info = env.step(40)
    assert (ended, info["reason"]) == (True, "all boxes are placed")
    board, box = env.layout().items
    assert (board.name, board.position, board.sequence) == ("board", (0.0, 0.0, 0.0), 0)
    assert (box.position, box.size, box.mass_offset) == (
        (0.0, 20.0, 0.0), (30.0, 20.0, 40.0), (-3.0, 0.0, -20.0)
    )  # fmt: skip


@pytest.mark.parametrize("size", [(100, 80, 50), (50, 80, 100)])
def test_a_box_may_be_as_large_as_the_pallet_either_way(size):
    box = Item(0, (0, 0, 0), size, 1.0)
    made(pallet=Pallet(100.0, 80.0, 50.0), boxes=[box])
    for side in range(3):
        longer = replace(box, size=tuple(s + 1 * (k == side) for k, s in enumerate(size)))
        with pytest.raises(OnlinePackingError, match="allowed: what fits the pallet"):
            made(pallet=Pallet(100.0, 80.0, 50.0), boxes=[longer])


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"boxes": []}, "there are no boxes; allowed: one or more"),
        ({"boxes": [Item(0, (0, 0, 0), (101, 5, 5), 1.0)]}, "box 0 is 101 x 5 x 5 cm; allowed"),
        ({"pallet": Pallet(30.0, 100.0, 100.0)}, "is drawn is 35 x 35 x 35 cm; allowed"),
        ({"cell": 0.0}, "cell is 0.0; allowed: a number, 0.05 to 100000 cm"),
        ({"cell": 0.1}, "cell is 0.1 cm: 2000000 actions; allowed: up to 100000"),
        ({"cell": float("nan")}, "cell is nan; allowed"),
        ({"pallet": (120, 160, 80)}, r"pallet is \(120, 160, 80\); allowed: a Pallet, or None"),
        ({"boxes": [(10, 10, 10)]}, r"box 0 is \(10, 10, 10\); allowed: an Item"),
    ],
)
def test_an_environment_that_cannot_be_is_refused(how, said):
    with pytest.raises(OnlinePackingError, match=said):
        made(**how)


def test_without_gymnasium_one_sentence_says_which_extra_brings_it():
    code = "import sys; sys.modules['gymnasium'] = None; import steadyload.gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    last = done.stderr.splitlines()[-1]
    assert last.endswith("steadyload.gym needs Gymnasium: pip install 'steadyload[gym]'")
