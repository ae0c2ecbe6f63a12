"""The yardstick of the wing skin: what clipping and chains alone take with NumPy and Shapely.

    python3 -m venv target/yardstick && target/yardstick/bin/pip install numpy shapely
    target/yardstick/bin/python benches/yardstick/wing_skin.py

It does of a flat ply what the planner does of any: each course's frame, the ply within its strip, the cuts of each
piece, and these split where the direction of U changes. It shares no code with the planner and prints how many pieces
and chains it finds and how long one round takes, reading the job left out.
"""

import json
import pathlib
import statistics
import time

import numpy as np
import shapely
from shapely.geometry import Polygon, box

REVERSAL_MM = 0.01
JOB = pathlib.Path(__file__).parents[2] / "tests/fixtures/roll/wing-skin-45.job.json"


def chains(points):
    """Pieces of a cut between changes of the sign of dU; steps below REVERSAL_MM are no change."""
    u = points[:, 0]
    turns, low, high, direction = 0, u[0], u[0], 0
    for value in u[1:]:
        low, high = min(low, value), max(high, value)
        if direction >= 0 and high - value >= REVERSAL_MM:
            turns += direction > 0
            direction, low, high = -1, value, value
        elif direction <= 0 and value - low >= REVERSAL_MM:
            turns += direction < 0
            direction, low, high = 1, value, value
    return turns + 1


def cuts(ring, half):
    """The parts of a ring off the strip's edges."""
    points = np.asarray(ring.coords)
    on_edge = np.abs(np.abs(points[:, 1]) - half) < 1e-9
    edges = on_edge[:-1] & on_edge[1:] & (points[:-1, 1] == points[1:, 1])
    if not edges.any():
        return [points]
    first = int(np.argmax(edges)) + 1
    points, edges = np.roll(points[:-1], -first, axis=0), np.roll(edges, -first)
    points = np.vstack([points, points[:1]])
    found, begin = [], 0
    for index in np.flatnonzero(edges):
        if index > begin:
            found.append(points[begin : index + 1])
        begin = index + 1
    return found


def plan(boundary, holes, tracks, width):
    half, pieces, found = width / 2.0, 0, 0
    for track in tracks:
        origin, end, normal = track[0, :3], track[-1, :3], track[0, 3:]
        along = (end - origin) / np.linalg.norm(end - origin)
        frame = np.stack([along, np.cross(normal, along)], axis=1)
        ply = Polygon((boundary - origin) @ frame, [(hole - origin) @ frame for hole in holes])
        low, _, high, _ = ply.bounds
        within = ply.intersection(box(low - 1.0, -half, high + 1.0, half))
        for piece in getattr(within, "geoms", [within]):
            if piece.geom_type != "Polygon" or piece.is_empty:
                continue
            pieces += 1
            for ring in [piece.exterior, *piece.interiors]:
                found += sum(chains(cut) for cut in cuts(ring, half))
    return pieces, found


def main():
    job = json.loads(JOB.read_text())["input"]
    boundary = np.array(job["boundary"]["points"])
    holes = [np.array(hole["points"]) for hole in job.get("holes", [])]
    tracks = [np.array([p["position"] + p["normal"] for p in t["points"]]) for t in job["tracks"]]
    width = job["tape"]["width_mm"]
    found = plan(boundary, holes, tracks, width)
    rounds = []
    for _ in range(50):
        begin = time.perf_counter()
        plan(boundary, holes, tracks, width)
        rounds.append(1e3 * (time.perf_counter() - begin))
    print(f"NumPy {np.__version__}, Shapely {shapely.__version__}: {found[0]} pieces, {found[1]} chains")
    print(f"clipping and chains: median {statistics.median(rounds):.1f} ms, fastest {min(rounds):.1f} ms")


if __name__ == "__main__":
    main()
