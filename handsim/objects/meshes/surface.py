"""Edges, patches and sides of a surface of triangles, as arrays."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import KDTree

from handsim.types import Array, Index, Mask


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """The edges of faces (m, 3), three a face in the order of the faces.

    Attributes
    ----------
    ends : (3 m, 2)
        Vertices from first to last, the way the face goes round.
    number : (3 m,)
        Which undirected edge each is.
    count : (n_edges,)
        Faces at each undirected edge.
    """

    ends: Index
    number: Index
    count: Index

    @classmethod
    def of(cls, faces: Index, patch: Index | None = None) -> "EdgeTable":
        """Return the edges; those of different patches (m,) count as different edges."""
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        n = int(faces.max()) + 1
        low, high = ends.min(axis=1), ends.max(axis=1)
        key = low * n + high
        if patch is not None:
            _, key = np.unique(key, return_inverse=True)
            key = key * (int(patch.max()) + 1) + np.repeat(patch, 3)
        _, number, count = np.unique(key, return_inverse=True, return_counts=True)
        return cls(ends, number, count)

    @property
    def open(self) -> Mask:
        """Which of the 3 m edges have no other face."""
        return np.asarray(self.count[self.number] == 1)

    def pairs(self) -> tuple[Index, Index, Mask]:
        """Return the faces that share an edge of two, and whether both run along it alike."""
        order = np.argsort(self.number, kind="stable")
        starts = np.cumsum(self.count) - self.count
        of_two = self.count == 2
        first, second = order[starts[of_two]], order[starts[of_two] + 1]
        alike = self.ends[first, 0] == self.ends[second, 0]
        return first // 3, second // 3, np.asarray(alike)


def patches(faces: Index) -> Index:
    """Return the number of the patch of each face: faces joined by edges of exactly two."""
    one, other, _ = EdgeTable.of(faces).pairs()
    graph = coo_array((np.ones(len(one)), (one, other)), shape=(len(faces), len(faces)))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def turned_alike(faces: Index, patch: Index) -> tuple[Index, int, Mask]:
    """Return faces that go round alike within each patch, how many were turned, and where it fails.

    Of each patch the smaller part is turned.

    Returns
    -------
    faces : (m, 3)
    n_turned
    bad : (n_patches,)
        Patches that have one side only.
    """
    one, other, alike = EdgeTable.of(faces, patch).pairs()
    n, n_patches = len(faces), int(patch.max()) + 1
    _, kept = np.unique(one * n + other, return_index=True)
    roots = np.unique(patch, return_index=True)[1]
    rows = np.concatenate([one[kept], np.full(n_patches, n)])
    columns = np.concatenate([other[kept], roots])
    values = np.concatenate([1.0 + alike[kept], np.ones(n_patches)])
    graph = coo_array((values, (rows, columns)), shape=(n + 1, n + 1)).tocsr()
    graph = (graph + graph.T).tocsr()
    order, before = breadth_first_order(graph, n, directed=False)
    relation = np.asarray(graph[before[order[1:]], order[1:]]).ravel() > 1.5
    flip = np.zeros(n + 1, dtype=bool)
    for node, parent, differs in zip(
        order[1:].tolist(), before[order[1:]].tolist(), relation.tolist(), strict=True
    ):
        flip[node] = flip[parent] ^ differs
    turn = flip[:n]
    bad = np.zeros(n_patches, dtype=bool)
    bad[patch[one[(turn[one] ^ turn[other]) != alike]]] = True
    share = np.bincount(patch, weights=turn, minlength=n_patches) / np.bincount(patch)
    turn = turn ^ (share > 0.5)[patch]
    faces = np.where(turn[:, None], faces[:, ::-1], faces)
    return faces, int(turn.sum()), bad


def boundary_loops(faces: Index) -> list[list[int]]:
    """Return the closed chains of open edges, each as vertices in the order of its faces."""
    edges = EdgeTable.of(faces)
    after: dict[int, list[int]] = {}
    for start, end in edges.ends[edges.open].tolist():
        after.setdefault(start, []).append(end)
    loops: list[list[int]] = []
    while after:
        start = next(iter(after))
        loop, at = [start], start
        while True:
            following = after[at].pop()
            if not after[at]:
                del after[at]
            if following == start or following not in after:
                break
            if following in loop:  # a bow tie: the part that is closed is a loop of its own
                cut = loop.index(following)
                loops.append(loop[cut:])
                loop = loop[:cut]
            loop.append(following)
            at = following
        loops.append(loop)
    return loops


def signed_volume(vertices: Array, faces: Index) -> float:
    """Return the volume enclosed, negative where faces go round the wrong way."""
    corners = vertices[faces] - vertices[faces[0, 0]]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def centroid(vertices: Array, faces: Index) -> Array:
    """Return the centre of volume of closed surfaces, (3,)."""
    origin = vertices[faces[0, 0]]
    corners = vertices[faces] - origin
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return origin + volumes @ corners.sum(axis=1) / 4 / volumes.sum()


def area(vertices: Array, faces: Index) -> float:
    """Return the area of a surface."""
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(across, axis=1).sum() / 2)


def winding(vertices: Array, faces: Index, point: Array) -> float:
    """Return how often a surface goes round a point: 1 inside a closed one, 0 outside.

    References
    ----------
    A. van Oosterom & J. Strackee (1983), IEEE Trans. Biomed. Eng. 30(2):125-126.
    """
    a, b, c = (vertices[faces[:, i]] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    over = np.einsum("ij,ij->i", a, np.cross(b, c))
    under = la * lb * lc + (
        np.einsum("ij,ij->i", a, b) * lc
        + np.einsum("ij,ij->i", b, c) * la
        + np.einsum("ij,ij->i", c, a) * lb
    )
    return float(2 * np.arctan2(over, under).sum() / (4 * np.pi))


def merged(vertices: Array, faces: Index, tolerance: float) -> tuple[Array, Index]:
    """Return a surface in which vertices that are nearer than ``tolerance`` are one."""
    used, faces = np.unique(faces, return_inverse=True)
    vertices, number = np.unique(vertices[used], axis=0, return_inverse=True)
    faces = number[faces.reshape(-1, 3)]
    near: Index = KDTree(vertices).query_pairs(tolerance, output_type="ndarray")
    if len(near) == 0:
        return vertices, faces
    n = len(vertices)
    graph = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    _, first = np.unique(group, return_index=True)
    return vertices[first], group.astype(np.int64)[faces]
