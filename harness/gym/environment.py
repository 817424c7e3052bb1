"""Packing online: boxes come one after the other, and each has to stand where it is put."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.errors import UserError, required, required_list
from steadyload.gym.library import gymnasium
from steadyload.gym.places import grid_of, heights_over, turned
from steadyload.layouts.model.checks import is_number
from steadyload.layouts.model.layout import SIDES, WEIGHTS, FloatArray, Item, Layout, Pallet, Vector
from steadyload.layouts.packing.packing import ITEM_CLASSES, WeightRule, make_instance, weigh
from steadyload.methods.contract.method import Method
from steadyload.methods.session.session import LoadingSession

Observation = dict[str, Any]
"""Arrays of 32-bit floats by name."""

_MOST_SEEDS = 2**31
_MOST_ACTIONS = 100_000


class OnlinePackingError(UserError):
    """An environment that cannot be, or an action that there is not; says what is allowed."""


class OnlinePacking(gymnasium.Env[Observation, np.int64]):
    """Boxes are packed onto a pallet in the order in which they come; each has to stand.

    The next box is let down over the deck: an action says over which cell of a grid its
    left-back corner lies, and whether it is turned by a quarter about the vertical axis. It comes
    to rest on the highest top below it. Action ``(turn * X + i) * Z + j`` is cell (i, j) of a grid
    of X times Z cells.

    The mask of actions (``action_masks()``, and ``info["action_mask"]``) is what
    :meth:`LoadingSession.feasible` says: where the loading would be stable with the box. Any other
    action ends the episode, and the box is not placed: ``info["reason"]`` says why. An episode also
    ends when the next box stands nowhere, or all boxes are placed.

    The observation: ``heights`` (X, Z), the highest top over every cell [cm], and ``box`` (7,):
    width, height, depth [cm], weight [kg] and offset of the centre of mass (x, y, z) [cm] of the
    next box; zeros when there is none. The reward of a step is the share of the pallet's volume
    that the box takes.

    Args:
        pallet: None for that of the item class.
        boxes: the boxes of every episode, in order; their positions and sequence numbers do not
            matter. None draws them anew in every episode.
        item_class: of the boxes that are drawn, a key of
            :data:`steadyload.layouts.packing.packing.ITEM_CLASSES`.
        box_count: of the boxes that are drawn; None for as many as the class has.
        method: that every placement has to be stable by.
        cell: side of a cell [cm]; None for a twentieth of the deck's longer side.
        render_mode: None; nothing is drawn.

    Attributes:
        pallet: that is packed.
        session: the loading so far.

    Raises:
        OnlinePackingError: a box fits the pallet in neither way, or a number is not allowed.
        SpecError: there is no such method.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self,
        pallet: Pallet | None = None,
        *,
        boxes: Sequence[Item] | None = None,
        item_class: int = 2,
        box_count: int | None = None,
        method: str | Method = "equilibrium",
        cell: float | None = None,
        render_mode: None = None,
    ) -> None:
        if render_mode is not None:
            raise OnlinePackingError(
                f"render_mode is {render_mode!r}; allowed: None, nothing is drawn"
            )
        drawn = make_instance(item_class, 0, seed=0, item_count=box_count)
        self._drawn = (item_class, len(drawn.sizes))
        self.pallet = drawn.pallet
        if pallet is not None:
            self.pallet = required(
                "pallet", pallet, Pallet, "a Pallet, or None", OnlinePackingError
            )
        if boxes is None:
            longest = ITEM_CLASSES[item_class].longest_side
            _check_fit("the longest box that is drawn", (longest,) * 3, self.pallet)
        self._given = (
            None
            if boxes is None
            else _fitting(
                tuple(required_list("boxes", boxes, "a list of Items, or None")), self.pallet
            )
        )
        self.session = LoadingSession(self.pallet, method)
        self._cell = _side_of_cells(cell, self.pallet)
        self._corners = grid_of(self.pallet, self._cell)
        count = int(np.prod(self._corners.shape[:2]))
        if 2 * count > _MOST_ACTIONS:
            raise OnlinePackingError(
                f"cell is {self._cell:g} cm: {2 * count} actions; allowed: up to {_MOST_ACTIONS}"
            )
        self.action_space = gymnasium.spaces.Discrete(2 * count)
        top = np.full(self._corners.shape[:2], self.pallet.height + 1.0, dtype=np.float32)
        least = np.array([0.0] * 4 + [-SIDES[1] / 2.0] * 3, dtype=np.float32)
        most = np.array([SIDES[1]] * 3 + [WEIGHTS[1]] + [SIDES[1] / 2.0] * 3, dtype=np.float32)
        self.observation_space = gymnasium.spaces.Dict(
            heights=gymnasium.spaces.Box(np.zeros_like(top), top),
            box=gymnasium.spaces.Box(least, most),
        )
        self._boxes: tuple[Item, ...] = ()
        self._next, self._over = 0, True
        self._mask = np.zeros(2 * count, dtype=bool)
        self._heights = np.zeros(2 * count)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Empty the pallet, and draw boxes unless they are given.

        Args:
            seed: the same seed draws the same boxes in this and all later episodes.
            options: there are none.
        """
        super().reset(seed=seed)
        self.session.undo(len(self.session))
        self._boxes = self._draw() if self._given is None else self._given
        self._next, self._over = 0, False
        self._look()
        return self._observation(), self._info("")

    def step(self, action: np.int64 | int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Let the next box down.

        Args:
            action: see the class.

        Returns:
            The observation, the reward, whether the episode has ended, False, and ``info``: the
            mask of actions, the share of the pallet's volume that is taken, and why the episode has
            ended.

        Raises:
            OnlinePackingError: there is no such action.
            gymnasium.error.ResetNeeded: the episode has ended.
        """
        self._check(action)
        if self._over:
            raise gymnasium.error.ResetNeeded("the episode has ended; allowed: reset()")
        number = int(action)
        if not self._mask[number]:
            return self._ended(f"box {self._next} does not stand by action {number}")
        item = self.placement(number)
        verdict = self.session.try_place(item)
        if not verdict.stable:  # a method that says otherwise when it is asked again
            return self._ended(verdict.reason)
        self._next += 1
        self._look()
        reason = ""
        if self._next == len(self._boxes):
            reason = "all boxes are placed"
        elif not self._mask.any():
            reason = f"box {self._next} stands nowhere"
        self._over = bool(reason)
        return self._observation(), self._share((item,)), self._over, False, self._info(reason)

    def _check(self, action: np.int64 | int) -> None:
        if not self.action_space.contains(action):
            raise OnlinePackingError(f"action is {action!r}; allowed: 0 to {len(self._mask) - 1}")

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions the next box stands by, in the form that sb3-contrib asks for."""
        return self._mask.copy()

    def resting_heights(self) -> FloatArray:
        """The height at which the next box would come to rest by every action [cm]."""
        return self._heights.copy()

    def placement(self, action: int) -> Item:
        """The next box where an action puts it, whether it would stand there or not.

        Args:
            action: see the class.

        Raises:
            OnlinePackingError: there is no such action, or no next box.
        """
        self._check(action)
        if not self._next < len(self._boxes):
            raise OnlinePackingError("no box is left to place; allowed: reset()")
        turn, cell = divmod(action, len(self._mask) // 2)
        x, z = self._corners.reshape(-1, 2)[cell].tolist()
        box = self._boxes[self._next]
        at = (x, float(self._heights[action]), z)
        return replace(turned(box) if turn else box, position=at)

    def layout(self, name: str = "episode") -> Layout:
        """Layout of the boxes placed in this episode, to be saved or judged.

        Raises:
            LayoutError: nothing has been placed.
        """
        return self.session.layout(name)

    def close(self) -> None:
        """Release resources of the method's engine."""
        self.session.close()

    def _draw(self) -> tuple[Item, ...]:
        item_class, count = self._drawn
        seed = int(self.np_random.integers(_MOST_SEEDS))
        sizes = make_instance(item_class, 0, seed=seed, item_count=count).sizes
        return tuple(
            Item(k, (0.0, 0.0, 0.0), size, weigh(size, WeightRule.PAPER))
            for k, size in enumerate(sizes)
        )

    def _look(self) -> None:
        """Find where the next box would come to rest, and whether it would stand there."""
        self._mask[:] = False
        self._heights[:] = 0.0
        if self._next == len(self._boxes):
            return
        corners = self._corners.reshape(-1, 2)
        box = self._boxes[self._next]
        lower, upper = self._loaded()
        for turn, item in enumerate((box, turned(box))):
            part = slice(turn * len(corners), (turn + 1) * len(corners))
            heights = heights_over(corners, np.array(item.size)[::2], lower, upper)
            places = np.stack((corners[:, 0], heights, corners[:, 1]), axis=1)
            self._heights[part] = heights
            self._mask[part] = self.session.feasible(item, places)

    def _ended(self, reason: str) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """The end of an episode by an action that places nothing."""
        self._next, self._over = len(self._boxes), True
        self._mask[:] = False
        return self._observation(), 0.0, True, False, self._info(reason)

    def _observation(self) -> Observation:
        side = np.array((self._cell, self._cell))
        heights = heights_over(self._corners, side, *self._loaded())
        box = np.zeros(7)
        if self._next < len(self._boxes):
            item = self._boxes[self._next]
            box[:] = (*item.size, item.weight, *item.mass_offset)
        return {"heights": heights.astype(np.float32), "box": box.astype(np.float32)}

    def _loaded(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corners of what is placed [cm], shape (J, 3) each."""
        items = self.session.items
        lower = np.array([item.position for item in items]).reshape(-1, 3)
        return lower, lower + np.array([item.size for item in items]).reshape(-1, 3)

    def _info(self, reason: str) -> dict[str, Any]:
        return {
            "action_mask": self._mask.astype(np.int8),
            "volume_share": self._share(self.session.items),
            "reason": reason,
        }

    def _share(self, items: Sequence[Item]) -> float:
        volume = sum(float(np.prod(item.size)) for item in items)
        return volume / float(np.prod(self.pallet.size))


def _side_of_cells(cell: float | None, pallet: Pallet) -> float:
    """The side of a cell [cm]."""
    if cell is None:
        return max(pallet.width, pallet.depth) / 20.0
    if not is_number(cell) or not SIDES[0] <= cell <= SIDES[1]:
        raise OnlinePackingError(
            f"cell is {cell!r}; allowed: a number, {SIDES[0]:g} to {SIDES[1]:g} cm"
        )
    return float(cell)


def _fitting(boxes: tuple[Item, ...], pallet: Pallet) -> tuple[Item, ...]:
    """The boxes, if each fits the empty pallet in one of the two ways."""
    if not boxes:
        raise OnlinePackingError("there are no boxes; allowed: one or more")
    for number, box in enumerate(boxes):
        required(f"box {number}", box, Item, "an Item", OnlinePackingError)
        _check_fit(f"box {number}", box.size, pallet)
    return boxes


def _check_fit(what: str, size: Vector, pallet: Pallet) -> None:
    """Refuse a box that fits an empty pallet in neither way."""
    width, height, depth = pallet.size
    a, tall, b = size
    if tall > height or not ((a <= width and b <= depth) or (b <= width and a <= depth)):
        raise OnlinePackingError(
            f"{what} is {a:g} x {tall:g} x {b:g} cm; allowed: what fits the pallet of "
            f"{width:g} x {height:g} x {depth:g} cm, turned about the vertical axis or not"
        )
