# SPDX-License-Identifier: BSD-3-Clause
"""An impact in space a second way: Runge and Kutta's steps in the impulse itself, or SciPy's along the hodograph of slip."""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


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


def hodograph(w, v, mu, e, law):
    """v⁺ and p (3 each) of one contact by any law, SciPy's DOP853 at 1e-13 in t = ln of what slip has left; to some 1e-11.

    With v_t = ρ d, d = (cos φ, sin φ), dp = ρ dt: dφ/dt and d ln ρ/dt are functions of φ alone, and v_n, p, ∫ v_n dp follow.
    """
    wn, wc, wt = w[0, 0], w[1:, 0], w[1:, 1:]
    compression = None

    def direction(angle):
        return np.array([np.cos(angle), np.sin(angle)])

    def missing(y):
        if compression is None:
            return y[2]
        p, work = compression
        return {"newton": y[2] + e * v[0], "poisson": y[3] - (1 + e) * p, "stronge": y[4] + e * e * work}[law]

    def rates(_, y):
        d, rho = direction(y[0]), np.exp(y[1])
        r = wc - mu * wt @ d
        return [-d[1] * r[0] + d[0] * r[1], d @ r, rho * (wn - mu * wc @ d), rho, rho * y[2]]

    def ended(_, y):
        return missing(y)

    def stopped(_, y):
        return y[1] - np.log(1e-14 * np.linalg.norm(v))

    ended.terminal = stopped.terminal = True
    ended.direction = 1
    y = np.array([np.arctan2(v[2], v[1]), np.log(np.hypot(v[1], v[2])), v[0], 0.0, 0.0])
    slips = True
    while slips:
        run = solve_ivp(
            rates, (0, 1e6), y, "DOP853", events=[ended, stopped], rtol=1e-13, atol=1e-14, max_step=0.5 / wn
        )
        y = run.y[:, -1]
        if len(run.t_events[1]):
            slips = False
        elif compression is not None:
            break
        else:
            compression, y = (y[3], y[4]), np.array([y[0], y[1], 0.0, y[3], 0.0])
            if missing(y) >= 0:
                break
    if slips:
        after = np.array([y[2], *(np.exp(y[1]) * direction(y[0]))])
    else:
        after, y[3] = _from_rest(w, v, mu, e, law, y, compression)
    return after, np.array([y[3], *np.linalg.solve(wt, after[1:] - v[1:] - wc * y[3])])


def _from_rest(w, v, mu, e, law, y, compression):
    """v⁺ and the normal impulse of a contact whose slip has ended."""
    wn, wc, wt = w[0, 0], w[1:, 0], w[1:, 1:]
    stick = np.linalg.solve(wt, wc)
    slope, rate = wn - wc @ stick, np.zeros(2)
    if np.linalg.norm(stick) > mu:
        d = _leads_away(wc, wt, mu)
        slope, rate = wn - mu * wc @ d, wc - mu * wt @ d
    normal, since, work = y[2:]
    begun = since
    if compression is None:
        compression = since - normal / slope, work - normal**2 / slope / 2
        normal, since, work = 0.0, compression[0], 0.0
    if law == "newton":
        p = since + (-e * v[0] - normal) / slope
    elif law == "poisson":
        p = (1 + e) * compression[0]
    else:
        need = -e * e * compression[1] - work
        p = since + (np.sqrt(normal**2 + 2 * slope * need) - normal) / slope
    return np.array([normal + slope * (p - since), *(rate * (p - begun))]), p


def _leads_away(wc, wt, mu):
    """The direction d in which W_tn − μ W_tt d points along d, by halves of the angle's bracket."""

    def turn(angle):
        d = np.array([np.cos(angle), np.sin(angle)])
        r = wc - mu * wt @ d
        return d[0] * r[1] - d[1] * r[0], d @ r

    grid = np.linspace(0, 2 * np.pi, 2001)
    for low, high in pairwise(grid):
        if turn(low)[0] * turn(high)[0] <= 0 and turn(low)[1] > 0:
            angle = brentq(lambda x: turn(x)[0], low, high, xtol=1e-15, rtol=1e-15)
            return np.array([np.cos(angle), np.sin(angle)])
    raise AssertionError
