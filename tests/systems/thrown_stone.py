# SPDX-License-Identifier: BSD-3-Clause
"""A stone of 1 kg that is thrown onto a level floor: it rebounds, slips and sticks."""

import kane as kn

MU, E = kn.parameter("mu", 0.3), kn.parameter("e", 0.6)
_N = kn.Frame("N")
_O = kn.Point("O", fixed_in=_N)
_X, _Y = kn.coordinates("x y")
_P = _O.at("P", _X * _N.x + _Y * _N.y)
FLOOR = kn.contact(kn.joints.point_on_plane("floor", _P, _O, normal=_N.y), MU, restitution=E)
SYSTEM = kn.System(
    _N, bodies=[kn.Particle("stone", _P, 1.0)], speeds="rates", loads=[kn.gravity(-9.81 * _N.y)], contacts=[FLOOR]
)
