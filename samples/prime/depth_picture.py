# SPDX-License-Identifier: Apache-2.0
"""Draws the depth of a torus as a grey PNG, with the Python module `sunstone` and NumPy.

    PYTHONPATH=build/release/lib/python python3 samples/prime/depth_picture.py -o depth.png
"""
import argparse
import struct
import zlib

import numpy as np
import sunstone


def torus(rings=96, sides=48):
    """Vertices (n, 3) and triangles (m, 3) of a torus around the z axis."""
    a, b = np.meshgrid(np.arange(rings) * 2 * np.pi / rings, np.arange(sides) * 2 * np.pi / sides,
                       indexing="ij")
    radius = 1 + 0.4 * np.cos(b)
    vertices = np.stack([radius * np.cos(a), radius * np.sin(a), 0.4 * np.sin(b)], -1)
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    corner = lambda x, y: (x % rings) * sides + y % sides
    first = np.stack([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)], -1)
    second = np.stack([corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)], -1)
    triangles = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])
    return vertices.reshape(-1, 3).astype(np.float32), triangles.astype(np.int32)


def camera_rays(width, height):
    eye = np.array([1.2, -2.4, 2.2])
    back = eye / np.linalg.norm(eye)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    x = (np.arange(width) + 0.5 - width / 2) / height
    y = (height / 2 - np.arange(height) - 0.5) / height
    directions = x[None, :, None] * right + y[:, None, None] * up - back
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return sunstone.rays(eye[None].astype(np.float32),
                         directions.reshape(-1, 3).astype(np.float32))


def write_png(path, grey):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))

    height, width = grey.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), grey], axis=1).tobytes()
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" +
                   chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description="Draws a depth picture (Python module sunstone)")
    parser.add_argument("-o", "--output", default="depth_picture.png")
    parser.add_argument("--width", type=int, default=768)
    parser.add_argument("--height", type=int, default=576)
    given = parser.parse_args()
    scene = sunstone.Scene(*torus())
    depth = scene.closest(camera_rays(given.width, given.height))["t"]
    hit = depth >= 0
    near, far = depth[hit].min(), depth[hit].max()
    grey = np.where(hit, 255 - 215 * (depth - near) / (far - near), 0)
    write_png(given.output, grey.astype(np.uint8).reshape(given.height, given.width))
    print(f"{given.output}: {hit.sum()} hits, depth {near:.3f} to {far:.3f}")


main()
