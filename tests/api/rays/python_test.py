# SPDX-License-Identifier: Apache-2.0
# The Python module `sunstone`: results, arrays used in place, errors.
import unittest

import numpy as np
import sunstone


def soup(count, seed):
    random = np.random.default_rng(seed)
    centres = random.uniform(-1, 1, (count, 1, 3))
    return (centres + random.uniform(-0.3, 0.3, (count, 3, 3))).reshape(-1, 3).astype(np.float32)


def brute_force(vertices, rays):
    """The distance of each ray's nearest hit in double precision, infinity without."""
    a, b, c = (vertices.reshape(-1, 3, 3)[:, k].astype(float) for k in range(3))
    nearest = []
    for ray in rays.astype(float):
        origin, direction = ray[0:3], ray[4:7]
        p = np.cross(direction, c - a)
        det = np.einsum("ij,ij->i", b - a, p)
        s = origin - a
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, b - a)
        v = q @ direction / det
        t = np.einsum("ij,ij->i", c - a, q) / det
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= ray[3]) & (t <= ray[7])
        nearest.append(np.min(t[inside], initial=np.inf))
    return np.array(nearest)


class Dlpack:
    """Only DLPack, as a tensor of another library."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self):
        return self.array.__dlpack__()


class Queries(unittest.TestCase):
    def setUp(self):
        self.vertices = soup(200, 1)
        self.scene = sunstone.Scene(self.vertices)
        random = np.random.default_rng(2)
        directions = random.normal(size=(500, 3)).astype(np.float32)
        self.rays = sunstone.rays(np.zeros((1, 3), np.float32), directions)

    def test_closest(self):
        hits = self.scene.closest(self.rays)
        expected = brute_force(self.vertices, self.rays)
        found = hits["t"] >= 0
        self.assertTrue(np.mean(found == np.isfinite(expected)) > 0.99)
        both = found & np.isfinite(expected)
        self.assertGreater(both.sum(), 100)
        np.testing.assert_allclose(hits["t"][both], expected[both], rtol=1e-3, atol=1e-4)
        self.assertTrue((hits["triangle"][~found] == -1).all())
        any_hits = self.scene.any(self.rays)
        self.assertTrue(((any_hits["t"] >= 0) == found).all())

    def test_out_is_written_in_place(self):
        out = np.full((500, 5), 7, np.float32)
        self.assertIs(self.scene.closest(self.rays, out), out)
        np.testing.assert_array_equal(out[:, 0], self.scene.closest(self.rays)["t"])

    def test_dlpack(self):
        indices = np.arange(600, dtype=np.int32).reshape(-1, 3)
        scene = sunstone.Scene(Dlpack(self.vertices), Dlpack(indices))
        out = np.zeros((500, 5), np.float32)
        scene.closest(Dlpack(self.rays), Dlpack(out))
        np.testing.assert_array_equal(out[:, 0], self.scene.closest(self.rays)["t"])

    def test_all(self):
        hits, offsets = self.scene.all(self.rays)
        closest = self.scene.closest(self.rays)
        self.assertEqual(offsets[-1], len(hits))
        for i in range(500):
            mine = hits[offsets[i]:offsets[i + 1]]
            self.assertEqual(len(mine) == 0, closest["t"][i] < 0)
            if len(mine):
                self.assertEqual(mine[0], closest[i])

    def test_nearest(self):
        scene = sunstone.Scene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32))
        found = scene.nearest(np.array([[0.2, 0.2, 2], [3, 0, 0]], np.float32), farthest=10)
        np.testing.assert_allclose(found["distance"], [2, 2])
        np.testing.assert_allclose(found["point"][1], [1, 0, 0])

    def test_instances(self):
        matrix = np.eye(4)
        matrix[0, 3] = 5
        top = sunstone.Scene([(self.scene, np.eye(4)), (self.scene, matrix[:3])])
        hits = top.closest(self.rays)
        first = hits["instance"] == 0
        self.assertGreater(first.sum(), 50)
        np.testing.assert_allclose(hits["t"][first], self.scene.closest(self.rays)["t"][first],
                                   rtol=1e-4, atol=1e-5)
        self.assertGreater((hits["instance"] == 1).sum(), 0)

    def test_errors(self):
        with self.assertRaisesRegex(ValueError, "float32"):
            sunstone.Scene(self.vertices.astype(float))
        with self.assertRaisesRegex(ValueError, r"\(n, 3\)"):
            sunstone.Scene(self.vertices.reshape(-1))
        with self.assertRaisesRegex(ValueError, r"vertices must have shape \(n, 3\)"):
            sunstone.Scene(np.zeros((3, 2), np.float32))
        with self.assertRaisesRegex(ValueError, "int32"):
            sunstone.Scene(self.vertices, np.zeros((1, 3), np.int64))
        with self.assertRaisesRegex(ValueError, "contiguous"):
            self.scene.closest(np.zeros((4, 16), np.float32)[:, ::2])
        with self.assertRaisesRegex(ValueError, "a row for each ray"):
            self.scene.closest(self.rays, np.zeros((3, 5), np.float32))
        with self.assertRaisesRegex(ValueError, "writeable"):
            out = np.zeros((500, 5), np.float32)
            out.flags.writeable = False
            self.scene.closest(self.rays, out)
        with self.assertRaisesRegex(ValueError, "DLPack"):
            self.scene.closest("rays")
        with self.assertRaisesRegex(ValueError, "byte order"):
            sunstone.Scene(self.vertices.astype(">f4"))
        with self.assertRaisesRegex(ValueError, "byte order"):
            self.scene.closest(self.rays.astype(">f4"))
        with self.assertRaisesRegex(ValueError, "have a scene"):
            sunstone.Scene([(None, np.eye(4))])
        with self.assertRaisesRegex(ValueError, "every three"):
            sunstone.Scene(self.vertices[:4])
        with self.assertRaises(ValueError):
            sunstone.rays(np.zeros((2, 3), np.float32), np.zeros((3, 3), np.float32))
        with self.assertRaises(ValueError):
            sunstone.Scene([(self.scene, np.eye(2))])
        with self.assertRaisesRegex(ValueError, "shape"):
            sunstone.Scene([(self.scene, [[1, 2], [3, 4]])])
        with self.assertRaises(ValueError):
            self.scene.nearest(np.zeros((1, 3), np.float32), -1)


if __name__ == "__main__":
    unittest.main()
