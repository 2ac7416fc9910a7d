# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A robot drives two rounds past trees and cars; its sensor does not identify them."""

import hybrid
import numpy as np

rng = np.random.default_rng(1)
names = ["tree", "car"]
k = np.arange(10)
angles, radii = 0.2 * np.pi * k + 0.1 * (k % 3), np.where(k % 2 == 0, 12, 8.5)
things = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
truth = [hybrid.SE2(10 * np.cos(0.1 * i), 10 * np.sin(0.1 * i), 0.1 * i + np.pi / 2) for i in range(126)]

mapper = hybrid.LandmarkMapper2()
for i, pose in enumerate(truth):
    seen = []
    for kind, (x, y) in zip(k % 2, pose.inverse() * things):
        if np.hypot(x, y) > 8:
            continue
        seen.append(hybrid.Detection(
            range=np.hypot(x, y) + 0.05 * rng.normal(), yaw=np.arctan2(y, x) + 0.01 * rng.normal(),
            covariance=np.diag([0.05**2, 0.01**2, 0]), class_probabilities=[0.2, 0.8] if kind else [0.8, 0.2]))
    frame = hybrid.DetectionFrame(is_3d=False, max_range=8, fov_yaw=2 * np.pi, class_names=names, detections=seen)
    sigmas = np.array([0.03, 0.03, 0.006])
    motion = pose if i == 0 else truth[i - 1].between(pose) * hybrid.SE2.exp(sigmas * rng.normal(size=3))
    mapper.add(motion, hybrid.Noise.diagonal(sigmas if i else [1e-3, 1e-3, 2e-4]), [frame])
mapper.finish()

estimate = mapper.smoother.estimate()
for landmark in mapper.landmarks:
    p = estimate.values[landmark.position]
    assert landmark.class_key is not None  # it has a class
    kind = estimate.assignment[landmark.class_key.key]
    nearest = np.linalg.norm(things - p, axis=1).argmin()
    print(f"{names[kind]} at {p.round(2)} m, seen {landmark.sightings} times")
    assert np.linalg.norm(things[nearest] - p) < 0.5 and nearest % 2 == kind
assert len(mapper.landmarks) == len(things)
