# SPDX-License-Identifier: BSD-3-Clause
"""An impact in space by Stronge's law a second way: Runge and Kutta's steps in the impulse itself, halves where a phase ends."""

import numpy as np


def stronge(w, v, mu, e, pieces=6000):
    """v⁺ (3), to some 1e-8."""
    wn, wc, wt = w[0, 0], w[1:, 0], w[1:, 1:]
    stick = np.linalg.solve(wt, wc)
    sticks = np.linalg.norm(stick) <= mu
    most = 4 * abs(v[0]) / (wn - wc @ stick) + 2 * np.linalg.norm(v[1:]) / np.linalg.eigvalsh(w)[0]
    y, stuck, compression = np.array([*v, 0.0]), False, None  # v and ∫ v_n dp

    def rates(y):
        if stuck:
            return np.array([wn - wc @ stick, 0, 0, y[0]])
        d = y[1:3] / np.linalg.norm(y[1:3])
        return np.array([wn - mu * (wc @ d), *(wc - mu * (wt @ d)), y[0]])

    def stepped(h):
        a = rates(y)
        b = rates(y + h / 2 * a)
        c = rates(y + h / 2 * b)
        return y + h / 6 * (a + 2 * b + 2 * c + rates(y + h * c))

    def halved(missing, high):
        low = 0.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if missing(stepped(middle)) < 0 else (low, middle)
        return stepped(high)

    while True:
        h = most / pieces
        if not stuck:
            h = min(h, 0.05 * np.linalg.norm(y[1:3]) / np.linalg.norm(rates(y)[1:3]) + 1e-13 * most)
        new = stepped(h)
        if not stuck and sticks and np.linalg.norm(new[1:3]) < 1e-9 * np.linalg.norm(v):
            stuck, new[1:3] = True, 0.0
        if compression is None and new[0] >= 0:
            new = halved(lambda z: z[0], h)
            compression, new[0], new[3] = new[3], 0.0, 0.0
        elif compression is not None and new[3] >= -e * e * compression:
            end = -e * e * compression
            return halved(lambda z, end=end: z[3] - end, h)[:3]
        y = new
