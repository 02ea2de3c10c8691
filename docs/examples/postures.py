# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a person stand, sit or lie? A random forest learns it from frames of an infrared array:

    python docs/examples/postures.py LEARN.csv [--on TRY.csv] [--trees 400]

The tables are those of `array_frames.py`, or real frames in the same form: rows of posture, person,
columns of the frame, and its temperatures with semicolons. Several rows in a row may be one spell:
give the median of their frames. Without --on, each person is tried on a forest that learnt from
the others. Needs scikit-learn alone.

The 13 features are of the shape only, relative to the warmest pixels: parts differ in how much of
the true warmth they read.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

try:
    import numpy as np
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import balanced_accuracy_score, confusion_matrix
    from sklearn.model_selection import GroupKFold, cross_val_predict
except ModuleNotFoundError as error:
    raise SystemExit(f"postures: {error}: run `pip install scikit-learn`") from None

FEATURES = (
    "pixels above 1/4", "pixels above 1/2", "pixels above 3/4", "warmth", "length", "width",
    "width by length", "box length", "box width", "fill of the box", "sharpness of the top",
    "top from the middle of the blob", "blob from the middle of the frame",
)  # fmt: skip
POSTURES = ("standing", "sitting", "lying")
Table = tuple[np.ndarray, np.ndarray, np.ndarray]


def blob_of(above: np.ndarray, top: int) -> np.ndarray:
    """The pixels (rows, columns) that hang together with pixel `top` and are `above`."""
    inside = np.zeros(above.shape, bool)
    inside.flat[top] = True
    while True:
        wider = np.pad(inside, 1)
        shifts = ((i, j) for i in range(3) for j in range(3))
        rows, columns = above.shape
        grown = above & np.any([wider[i : i + rows, j : j + columns] for i, j in shifts], axis=0)
        grown.flat[top] = True
        if (grown == inside).all():
            return inside
        inside = grown


def features(frame: np.ndarray) -> list[float]:
    """The 13 features of a frame (rows, columns) in °C."""
    excess = frame - np.median(frame)
    padded = np.pad(excess, 1, mode="edge")
    rows, columns = excess.shape
    near = [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    smooth = np.mean(near, axis=0)
    top = int(smooth.argmax())
    warmest = max(float(np.sort(excess, axis=None)[-3:].mean()), 1e-6)
    share = np.clip(excess / warmest, 0.0, 1.0)
    quarter = blob_of(smooth > 0.25 * smooth.flat[top], top)
    half = blob_of(smooth > 0.5 * smooth.flat[top], top)
    weight = np.where(quarter, share, 0.0) + 1e-9 * quarter
    y, x = np.mgrid[:rows, :columns].astype(float)
    total = weight.sum()
    middle = np.array([(weight * x).sum(), (weight * y).sum()]) / total
    dx, dy = x - middle[0], y - middle[1]
    moments = np.array([[dx * dx, dx * dy], [dx * dy, dy * dy]])
    spread = (weight * moments).sum(axis=(2, 3)) / total
    sizes, ways = np.linalg.eigh(spread + np.eye(2) / 12.0)
    width, length = np.sqrt(sizes).tolist()
    points = np.stack([x[half], y[half]], 1) @ ways
    across, along = (np.ptp(points, axis=0) + 1.0).tolist()
    head = np.array([top % columns, top // columns], float)
    centre = np.array([columns - 1, rows - 1]) / 2.0
    return [
        float(np.count_nonzero(quarter & (share > 0.25))),
        float(np.count_nonzero(quarter & (share > 0.5))),
        float(np.count_nonzero(quarter & (share > 0.75))),
        float(total),
        length,
        width,
        width / length,
        along,
        across,
        float(half.sum()) / (along * across),
        float(smooth.flat[top] / warmest),
        float(np.linalg.norm(head - middle)),
        float(np.linalg.norm(middle - centre)) / columns,
    ]


def read(path: Path) -> Table:
    """The features (n, 13), the postures (n,) and the persons (n,) of a table of frames."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows or "frame_c" not in rows[0]:
        raise SystemExit(f"postures: {path} has no frames: make them by array_frames.py")

    def frames() -> Iterator[np.ndarray]:
        for row in rows:
            values = np.array(row["frame_c"].split(";"), float)
            yield values.reshape(-1, int(row["columns"]))

    found = np.array([features(frame) for frame in frames()])
    return found, *(np.array([row[name] for row in rows]) for name in ("posture", "person"))


def main() -> None:
    said = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    said.add_argument("table", type=Path, metavar="LEARN.csv")
    said.add_argument("--on", type=Path, metavar="TRY.csv", help="other frames to be tried on")
    said.add_argument("--trees", type=int, default=400)
    asked = said.parse_args()
    known, posture, person = read(asked.table)
    forest = RandomForestClassifier(
        asked.trees, min_samples_leaf=4, class_weight="balanced", random_state=1
    )
    if asked.on is None:
        folds = GroupKFold(min(5, len(set(person))))
        found = cross_val_predict(forest, known, posture, groups=person, cv=folds)
        wanted = posture
    else:
        shown, wanted, _ = read(asked.on)
        found = forest.fit(known, posture).predict(shown)
    print(f"| right, balanced | {balanced_accuracy_score(wanted, found):.2f} |")
    print("\n| is | said standing | sitting | lying |\n|---|---|---|---|")
    for name, row in zip(POSTURES, confusion_matrix(wanted, found, labels=POSTURES), strict=True):
        print(f"| {name} | {' | '.join(map(str, row))} |")


if __name__ == "__main__":
    main()
