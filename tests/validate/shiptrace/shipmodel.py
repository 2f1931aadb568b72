"""A plain ship of 30 m: triangles for the reference, and the same as a glTF
file for the program. Model's frame: x to the bow, y to port, z up, metres, 0 in
the waterline."""
import base64
import json

import numpy as np

LENGTH, BEAM, DRAUGHT = 30.0, 7.0, 2.5
# Reflectances of the paints.
HULL, DECK, HOUSE, MAST, BOTTOM = 0.06, 0.25, 0.6, 0.35, 0.3


def _outward(corners, centre):
    a, b, c = corners
    if np.dot(np.cross(b - a, c - a), (a + b + c) / 3 - centre) < 0:
        return np.array([a, c, b])
    return np.array(corners)


def _box(low, high, albedo):
    low, high = np.array(low, float), np.array(high, float)
    found = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (low, high):
            quad = []
            for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = side.copy()
                p[u], p[v] = (low, high)[i][u], (low, high)[j][v]
                quad.append(p)
            for t in ((0, 1, 2), (0, 2, 3)):
                found.append((_outward([quad[k] for k in t],
                                       (low + high) / 2), albedo))
    return found


def _section(x):
    """From the keel up to the deck's edge, to port; the deck's middle last."""
    s = x / (LENGTH / 2)
    fine = 1 - max(s, 0) ** 2.4 - 0.35 * max(-s, 0) ** 3
    half = BEAM / 2 * max(fine, 0.004)
    keel = -DRAUGHT * max(1 - max(s, 0) ** 6 - 0.6 * max(-s, 0) ** 4, 0.05)
    deck = 2.2 + 1.3 * max(s, 0) ** 2
    points = [(x, 0, keel)]
    for k in range(1, 6):
        t = k / 5
        points.append((x, half * np.sqrt(1 - (1 - t) ** 2), keel * (1 - t)))
    points.append((x, half * 1.12 + 0.02, deck))
    return np.array(points + [(x, 0, deck)])


def _hull():
    stations = [_section(x) for x in np.linspace(-LENGTH / 2, LENGTH / 2, 25)]
    found = []

    def face(corners, albedo, centre):
        area = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        if np.dot(area, area) > 1e-12:
            found.append((_outward(corners, centre), albedo))

    mirror = np.array([1, -1, 1])
    for a, b in zip(stations, stations[1:]):
        centre = np.array([(a[0, 0] + b[0, 0]) / 2, 0, 0.3])
        for k in range(len(a) - 1):
            paint = BOTTOM if k < 5 else HULL if k == 5 else DECK
            for side in (np.ones(3), mirror):
                quad = [p * side for p in (a[k], b[k], b[k + 1], a[k + 1])]
                face([quad[0], quad[1], quad[2]], paint, centre)
                face([quad[0], quad[2], quad[3]], paint, centre)
    for end in (stations[0], stations[-1]):
        middle = np.array([end[0, 0], 0, 0.5])
        for k in range(len(end) - 1):
            for side in (np.ones(3), mirror):
                paint = BOTTOM if k < 5 else HULL
                face([middle, end[k] * side, end[k + 1] * side], paint,
                     np.zeros(3))
    return found


def triangles():
    """(n, 3, 3) corners, (n,) reflectances."""
    found = (_hull() + _box((-11, -2.6, 2.0), (-1, 2.6, 5.4), HOUSE)
             + _box((-7.5, -2.2, 5.4), (-2, 2.2, 8.2), HOUSE)
             + _box((-5, -0.2, 8.2), (-4.6, 0.2, 14.5), MAST)
             + _box((8, -0.15, 2.2), (8.3, 0.15, 9), MAST)
             + _box((-10, -0.9, 5.4), (-8.4, 0.9, 7.6), HULL))
    return (np.array([corners for corners, _ in found]),
            np.array([albedo for _, albedo in found]))


def gltf():
    """The text of a file of it; described by DESCRIPTION."""
    corners, albedo = triangles()
    views, accessors, meshes, blob = [], [], [], b""
    paints = sorted(set(albedo))
    for material, paint in enumerate(paints):
        part = corners[albedo == paint].reshape(-1, 3).astype("<f4")
        views.append({"buffer": 0, "byteOffset": len(blob),
                      "byteLength": part.nbytes})
        accessors.append({"bufferView": material, "componentType": 5126,
                          "count": len(part), "type": "VEC3",
                          "min": part.min(0).tolist(),
                          "max": part.max(0).tolist()})
        meshes.append({"attributes": {"POSITION": material},
                       "material": material, "mode": 4})
        blob += part.tobytes()
    data = base64.b64encode(blob).decode()
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "ship"}],
        "meshes": [{"primitives": meshes}],
        "materials": [{"pbrMetallicRoughness": {
            "baseColorFactor": [paint, paint, paint, 1], "metallicFactor": 0,
            "roughnessFactor": 1}} for paint in paints],
        "buffers": [{"uri": "data:application/octet-stream;base64," + data,
                     "byteLength": len(blob)}],
        "bufferViews": views, "accessors": accessors})


DESCRIPTION = json.dumps({"bow": "X", "up": "Z", "scale": 1,
                          "draught": DRAUGHT})
