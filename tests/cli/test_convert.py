# SPDX-License-Identifier: BSD-3-Clause
"""`kane convert`: models of other tools become Python files that kane takes, with the same equations."""

import pytest

import kane as kn
from kane.cli import model_of
from tests.cli.command import kane, line
from tests.interop.robots import texts as robots

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.02" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="10" velocity="3"/></joint></robot>
"""
MJCF = """<mujoco><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.4"/></body></worldbody></mujoco>
"""
AUTOLEV = """Newtonian N
Bodies B
Points O
Constants L=1, G=9.81, M=2
Variables Q', U'
Mass B=M
Inertia B, 0, M*L^2/12, M*L^2/12
Simprot(N, B, 3, Q)
P_O_Bo> = L/2*B1>
Q' = U
W_B_N> = U*B3>
V_O_N> = 0>
V2pts(N, B, O, Bo)
Gravity(-G*N2>)
Zero = Fr() + FrStar()
"""
SYMPY = """from sympy import symbols
from sympy.physics.mechanics import KanesMethod, Particle, Point, ReferenceFrame, dynamicsymbols

def pendulum():
    q, u = dynamicsymbols("q u")
    m, l, g = symbols("m l g")
    N = ReferenceFrame("N")
    A = N.orientnew("A", "Axis", [q, N.z])
    O = Point("O")
    O.set_vel(N, 0)
    P = O.locatenew("P", -l * A.y)
    P.set_vel(N, l * u * A.x)
    A.set_ang_vel(N, u * N.z)
    method = KanesMethod(N, [q], [u], kd_eqs=[q.diff() - u])
    method.kanes_equations([Particle("P", P, m)], [(P, -m * g * N.y)])
    return method
"""
SOURCES = {"arm.urdf": URDF, "robot.xml": URDF, "arm.xml": MJCF, "pendulum.al": AUTOLEV, "model.py:pendulum": SYMPY}

INPUTS = {name: {"inputs": {"tau_shoulder": 0.0}} for name in ("arm.urdf", "robot.xml")}


@pytest.mark.parametrize("source", SOURCES)
def test_a_model_of_another_tool(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / source.partition(":")[0]
    path.write_text(SOURCES[source])
    done = kane("convert", source, "--out", "made.py")
    assert "Next: kane check made.py" in line(done.stderr)
    text = (tmp_path / "made.py").read_text()
    eom = kn.derive(model_of("made.py").system)
    read = {
        "arm.urdf": kn.from_urdf,
        "robot.xml": kn.from_urdf,
        "arm.xml": kn.from_mjcf,
        "pendulum.al": kn.from_autolev,
    }
    if source in read:
        assert eom.operations == kn.derive(read[source](path).system).operations
        if read[source] is not kn.from_autolev:
            assert model_of("made.py").start == {
                "q": {"q_shoulder": 0.0},
                "u": {"u_shoulder": 0.0},
                **INPUTS.get(source, {}),
            }
    assert eom.operations.total > 0
    assert text == kane("convert", source).stdout
    again = kane("convert", "made.py").stdout
    assert again.partition("def system()")[2] == text.partition("def system()")[2]


def test_a_robot_begins_where_its_loop_is_closed_with_stops_if_asked(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.xml").write_text(robots.MODELS["coupled tendon"])
    (tmp_path / "arm.urdf").write_text(URDF)
    kane("convert", "loop.xml", "--out", "loop.py")
    loop = model_of("loop.py")
    assert kn.assemble(kn.derive(loop.system), **loop.start).q
    kane("convert", "arm.urdf", "--stops", "--out", "arm.py")
    assert [c.name for c in model_of("arm.py").system.contacts] == ["shoulder lower", "shoulder upper"]
    assert "Expected a file of URDF or MJCF with --stops" in line(kane("convert", "pendulum", "--stops", code=2).stderr)


def test_a_system_of_the_gallery():
    text = kane("convert", "double_pendulum").stdout
    assert text.startswith('"""double pendulum."""')
    assert "B2 = N.rotate(" in text


def test_what_is_refused(tmp_path):
    assert "which does not exist" in line(kane("convert", "absent.urdf", code=2).stderr)
    (tmp_path / "a.txt").write_text("x")
    assert "Expected a file that ends in .urdf" in line(kane("convert", tmp_path / "a.txt", code=2).stderr)
    (tmp_path / "m.py").write_text("a = 1\n")
    assert "Expected a name defined in" in line(kane("convert", f"{tmp_path / 'm.py'}:b", code=2).stderr)
    assert "which only its source file can declare" in line(kane("convert", "flexible_arm", code=1).stderr)


def test_a_python_model_keeps_its_title_start_and_span(tmp_path, monkeypatch):
    """The span was left out, so that what was made of a model moved for another time."""
    monkeypatch.chdir(tmp_path)
    head = "import kane as kn\nfrom kane.gallery.pendulum import system\n"
    own = "TITLE = 'a \"swing\"'\nSPAN = (1, 3)\nSTART = {'q': {'theta': kn.guess(0.5)}, 'u': {'u_theta': 0}}\n"
    (tmp_path / "model.py").write_text(head + own)
    kane("convert", "model.py", "--out", "made.py")
    made = model_of("made.py")
    assert made.span == (1.0, 3.0)
    assert made.title == 'a "swing"'
    assert made.start == {"q": {"theta": kn.guess(0.5)}, "u": {"u_theta": 0.0}}
    kane("convert", "pendulum", "--out", "other.py")
    assert "SPAN" not in (tmp_path / "other.py").read_text()
    with pytest.raises(kn.KaneError, match="span= two times"):
        kn.exchange.to_python(made.system, span=(1.0,))
