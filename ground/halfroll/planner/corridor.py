"""Corridors: the straight walls between which a leg is flown, from the polygons of a fence.

Why: staying inside a polygon is no smooth limit, and outside of one not even convex. Around the straight line of a leg
there is a convex region that no edge of the fence enters: for each edge one wall, through the edge's nearest point and
square to the shortest way there. Inside these walls the optimiser and the proof see linear limits only, whatever the
polygon's shape; a leg whose straight line meets the fence is refused.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll.missions.mission import Fence

Array = NDArray[np.float64]
Wall = tuple[float, float, float]  # unit normal and offset: normal . (x, y) <= offset

_LOOKS = 101  # at a line that crosses a fence, for where it is farthest beyond
_ON_THE_FENCE = 1e-3  # [m] that a path through a waypoint on the fence itself may pass it


def outside_by(position: ArrayLike, fence: Fence) -> float:
    """[m] from a position (2,) or (3,) to where the fence allows to be; 0 where it is allowed."""
    point = np.asarray(position, dtype=np.float64)[:2]
    if inside(point, fence) == fence.keep_in:
        return 0.0
    distance = min(float(np.linalg.norm(_nearest(point, point, *edge)[1] - point)) for edge in _edges(fence))
    return 0.0 if distance <= _ON_THE_FENCE else distance


def inside(point: Array, fence: Fence) -> bool:
    """Whether a ray from the point crosses the polygon an odd number of times."""
    crossings = 0
    for (x1, y1), (x2, y2) in ((tuple(a), tuple(b)) for a, b in _edges(fence)):
        if (y1 > point[1]) != (y2 > point[1]) and point[0] < x1 + (point[1] - y1) * (x2 - x1) / (y2 - y1):
            crossings += 1
    return crossings % 2 == 1


def meets(start: ArrayLike, end: ArrayLike, fence: Fence) -> bool:
    """Whether the straight line from start to end crosses an edge of the fence."""
    a, b = (np.asarray(point, dtype=np.float64)[:2] for point in (start, end))
    return any(_cross(a, b, *edge) for edge in _edges(fence))


def crossed(start: ArrayLike, end: ArrayLike, fence: Fence) -> tuple[Array, float]:
    """Where (2,) the straight line from start to end, which meets the fence, goes farthest beyond it, and how far [m];
    to a hundredth of its length."""
    a, b = (np.asarray(point, dtype=np.float64)[:2] for point in (start, end))
    along = a + np.linspace(0.0, 1.0, _LOOKS)[:, None] * (b - a)
    beyond = [outside_by(point, fence) for point in along]
    worst = int(np.argmax(beyond))
    return along[worst], beyond[worst]


def walls(start: ArrayLike, end: ArrayLike, fences: Sequence[Fence]) -> list[Wall]:
    """Around the straight line from start to end (2,) or (3,), which meets no fence; the nearest wall first."""
    a, b = (np.asarray(point, dtype=np.float64)[:2] for point in (start, end))
    near = []
    for fence in fences:
        for p, q in _edges(fence):
            here, there = _nearest(a, b, p, q)
            near.append((float(np.linalg.norm(there - here)), here, there, p, q, fence))
    kept: list[Wall] = []
    for distance, here, there, p, q, fence in sorted(near, key=lambda found: found[0]):
        if any(min(x * p[0] + y * p[1], x * q[0] + y * q[1]) >= offset - 1e-9 for x, y, offset in kept):
            continue  # this edge lies behind a wall already
        normal = (there - here) / distance if distance > _ON_THE_FENCE else _outward(there, p, q, fence)
        offset = float(normal @ there) + (_ON_THE_FENCE if distance <= _ON_THE_FENCE else 0.0)
        kept.append((float(normal[0]), float(normal[1]), offset))
    return kept


def _edges(fence: Fence) -> list[tuple[Array, Array]]:
    corners = [np.array(corner, dtype=np.float64) for corner in fence.corners]
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def _outward(there: Array, p: Array, q: Array, fence: Fence) -> Array:
    """The normal of an edge that a leg touches there, towards where the fence does not allow to be."""
    along = q - p
    normal = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-12)
    allowed = inside(there + 0.1 * _ON_THE_FENCE * normal, fence) == fence.keep_in
    return np.asarray(-normal if allowed else normal)


def _nearest(a: Array, b: Array, p: Array, q: Array) -> tuple[Array, Array]:
    """The closest points of segments ab and pq that do not cross: one of them is an end."""
    pairs = [(_on(p, a, b), p), (_on(q, a, b), q), (a, _on(a, p, q)), (b, _on(b, p, q))]
    return min(pairs, key=lambda pair: float(np.linalg.norm(pair[1] - pair[0])))


def _on(point: Array, a: Array, b: Array) -> Array:
    """The point of segment ab that is closest to `point`."""
    along = b - a
    square = float(along @ along)
    share = 0.0 if square == 0.0 else min(max(float((point - a) @ along) / square, 0.0), 1.0)
    return np.asarray(a + share * along)


def _cross(a: Array, b: Array, p: Array, q: Array) -> bool:
    """Whether two segments properly cross: touching is allowed."""

    def side(u: Array, v: Array, w: Array) -> float:
        return float((v[0] - u[0]) * (w[1] - u[1]) - (v[1] - u[1]) * (w[0] - u[0]))

    return side(a, b, p) * side(a, b, q) < 0.0 and side(p, q, a) * side(p, q, b) < 0.0
