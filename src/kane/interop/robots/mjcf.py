# SPDX-License-Identifier: BSD-3-Clause
"""MJCF, MuJoCo's format: trees, closures, tendons and actuators; MuJoCo's soft constraints become exact.

MuJoCo's reader, in a process with bounds on memory and time, resolves defaults, includes, replications and inertias of shapes;
this module uses the compiled model. Before that `xml_text` checks the text: all files that it names must be in one folder. Sources:
https://mujoco.readthedocs.io/en/stable/XMLreference.html and computation/index.html.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from kane import expect
from kane.errors import ModelError, cut
from kane.interop.imported import Imported, Remarks
from kane.interop.robots.build import Options, Symbolic, built, plain
from kane.interop.robots.records import (
    Actuation,
    Closure,
    Coupling,
    Kind,
    LinkShape,
    Move,
    Placement,
    Robot,
    RobotLink,
    Strand,
)
from kane.interop.robots.xml_text import Element, given, parsed
from kane.numeric.arrays import Array
from kane.space.attitude_formulas import cosines_of

JOINTS: tuple[Kind, ...] = ("free", "ball", "slide", "hinge")
"""In the order of MuJoCo's enumerations, like the tuples below."""
SHAPES = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
OBJECTS = {"body": 1, "joint": 3, "site": 6, "mesh": 7, "tendon": 18, "actuator": 19, "equality": 17}
ARRAYS = {
    "body": "body_mass",
    "joint": "jnt_type",
    "site": "site_bodyid",
    "mesh": "mesh_vertadr",
    "tendon": "tendon_num",
    "actuator": "actuator_trntype",
    "equality": "eq_type",
}
"""An array with one row for each object of a kind."""
TAGS = {
    "actuator": ("motor", "position", "velocity", "general", "damper", "intvelocity", "cylinder", "muscle", "adhesion"),
    "equality": ("connect", "weld", "joint", "tendon"),
    "tendon": ("spatial", "fixed"),
    "joint": ("joint", "freejoint"),
}
CONNECT, WELD, JOINT, TENDON = range(4)
RATES: Mapping[str, Literal["", "integrator", "filter"]] = MappingProxyType(
    {"NONE": "", "INTEGRATOR": "integrator", "FILTER": "filter", "FILTEREXACT": "filter"}
)
"""The supported dynamics of actuators."""
ACTING = {"spring", "damper", "passive", "actuation", "equality", "constraint"}
"""Effects that the system has even if an option of the model disables them."""
SITE_WRAP, JOINT_WRAP = 3, 1
NOT_READ: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "dof_dampingpoly": ("dof", "damping that is not linear"),
        "jnt_stiffnesspoly": ("joint", "a spring that is not linear"),
        "jnt_springyield": ("joint", "a plastic spring"),
        "tendon_stiffnesspoly": ("tendon", "a spring that is not linear"),
        "tendon_dampingpoly": ("tendon", "damping that is not linear"),
        "tendon_springyield": ("tendon", "a plastic spring"),
        "tendon_armature": ("tendon", "an armature"),
        "tendon_frictionloss": ("tendon", "dry friction"),
        "actuator_armature": ("actuator", "an armature"),
        "actuator_damping": ("actuator", "damping"),
        "actuator_dampingpoly": ("actuator", "damping that is not linear"),
        "tendon_actfrclimited": ("tendon", "a limit on actuator forces on it"),
        "actuator_actearly": ("actuator", "an activation that acts a step early"),
        "actuator_actlimited": ("actuator", "a bounded activation"),
        "actuator_delay": ("actuator", "a delay"),
    }
)
"""Arrays of MuJoCo's model that are refused if they are not zero."""


def from_mjcf(
    source: str | bytes | Path,
    *,
    parameters: Symbolic = "all",
    damping: bool = True,
    friction: bool = False,
    stops: bool = False,
    folder: str | Path | None = None,
    timeout: float = 60.0,
) -> Imported:
    """Read a MuJoCo model as a system: bodies, joints, equality constraints, tendons and actuators, without contacts.

    Coordinates q_<joint> have MuJoCo's values; those of ball and free joints are e0_<joint>, …, x_<joint>, …, with speeds along
    the axes of the body. Inputs have the names of the actuators.

    Parameters
    ----------
    source : path of the file, or its text, which must not name other files
    parameters : which numbers of bodies become parameters with these defaults: "all", "masses" or "none"
    damping : whether joints are damped
    friction : whether the joints' frictionloss acts, as `kn.joints.stiction`
    stops : whether limits of joints become stops, and those of tendons ropes
    folder : folder that must contain all files that are opened, by default the model's
    timeout : limit in seconds for MuJoCo's reader, which runs in a separate process

    Returns
    -------
    Imported
        MuJoCo's soft constraints become exact. `remarks` list these changes and elements that are not read; `extras` contain
        "limits", "shapes", "controls" (bounds of inputs, which are not enforced) and "names"

    Raises
    ------
    ModelError
        if MuJoCo cannot read it, a file is outside the folder, or it contains elements other than rigid bodies
    """
    model, root = read(source, folder, timeout)
    options = Options(parameters, stops, damping, friction)
    return built(_MjcfReader(model, root).robot(), options)


def rotation_of(quaternion: Any) -> Array:
    """Direction cosines of a quaternion, the scalar first."""
    return plain(cosines_of(np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion), unit=True))


class _MjcfReader:
    """Reads MuJoCo's arrays by name."""

    def __init__(self, model: Any, root: Element) -> None:
        self.m, self.root, self.source = model, root, root.source
        self.remarks = Remarks()
        self.lines = {(e.tag, e.attributes["name"]): e.where for e in root.walk() if "name" in e.attributes}
        self._names: dict[str, list[str]] = {}
        for what in OBJECTS:  # bodies before joints, which may be named after them
            self._names[what] = self._named(what)

    def _named(self, what: str) -> list[str]:
        """The names of all objects of a kind; objects without a name are numbered."""
        result: dict[str, None] = {}
        for k in range(len(getattr(self.m, ARRAYS[what]))):
            name = mujoco().mj_id2name(self.m, OBJECTS[what], k) or self._unnamed(what, k)
            while name in result:
                name += "_"
            result[name] = None
        return [*result]

    def _unnamed(self, what: str, k: int) -> str:
        if what != "joint":
            return f"{what}_{k}"
        body = int(self.m.jnt_bodyid[k])
        own = self._names["body"][body]
        return own if self.m.body_jntnum[body] == 1 else f"{own}_{k - int(self.m.body_jntadr[body]) + 1}"

    def name(self, what: str, k: Any) -> str:
        """The name of an object."""
        return self._names[what][int(k)]

    def where(self, what: str, name: str) -> str:
        """The position of a named element in the text, "" if it is not found."""
        tags = TAGS.get(what, (what,))
        return next((self.lines[t, name] for t in tags if (t, name) in self.lines), self.source)

    def refuse(self, what: str, k: int, text: str) -> None:
        """Adds a remark that an object is not read."""
        name = self.name(what, k)
        self.remarks.say("refused", f"{what} {name!r}: {text}", self.where(what, name))

    # The tree ------------------------------------------------------------------------------------------------------

    def robot(self) -> Robot:
        """The robot's record."""
        m = self.m
        self._remark_world()
        links = tuple(self._link(b) for b in range(1, m.nbody))
        strands = tuple(s for k in range(m.ntendon) if (s := self._strand(k)) is not None)
        couplings, closures = self._equalities()
        read = {s.name for s in strands}
        for c in [c for c in couplings if c.what == "tendon" and not {c.first, c.second or c.first} <= read]:
            self.remarks.say("refused", f"equality {c.name!r}: of a tendon that is not imported", c.where)
            couplings.remove(c)
        drives = tuple(d for k in range(m.actuator_trntype.shape[0]) if (d := self._drive(k, strands)) is not None)
        bounds = {
            self.name("actuator", k): tuple(m.actuator_ctrlrange[k].tolist())
            for k in range(m.actuator_trntype.shape[0])
            if m.actuator_ctrllimited[k]
        }
        no_gravity = int(m.opt.disableflags) & int(mujoco().mjtDisableBit.mjDSBL_GRAVITY)
        gravity = np.zeros(3) if no_gravity else np.array(m.opt.gravity, dtype=float)
        shapes = tuple(self._shapes())
        return Robot(
            self.root.attributes.get("model", "model"), links, gravity, tuple(couplings), closures, strands, drives, shapes,
            self.remarks.all(), MappingProxyType({"controls": MappingProxyType(bounds)}),
        )  # fmt: skip

    def _remark_world(self) -> None:
        m = self.m
        if m.ngeom:
            self.remarks.say("ignored", f"contacts of {m.ngeom} geoms: declare them by kn.contact", self.source)
        if m.nsensor:
            self.remarks.say("ignored", f"{m.nsensor} sensors", self.source)
        if m.nkey:
            self.remarks.say("ignored", f"{m.nkey} keyframes: a motion starts at the reference pose", self.source)
        if float(m.opt.density) or float(m.opt.viscosity):
            self.remarks.say("refused", "the medium: its density and viscosity have no effect here", self.source)
        if int(m.opt.disableactuator):
            self.remarks.say("refused", "<option> disables groups of actuators", self.source)
        bits = mujoco().mjtDisableBit.__members__.items()
        off = {name.removeprefix("mjDSBL_").lower() for name, bit in bits if int(bit) & int(m.opt.disableflags)}
        if acting := off & ACTING:
            self.remarks.say("refused", f"<option> disables {', '.join(sorted(acting))}", self.source)
        if rest := off - ACTING - {"gravity", "mjndisable"}:
            self.remarks.say("ignored", f"<option> disables {', '.join(sorted(rest))}", self.source)
        for b in range(1, m.nbody):
            if m.body_mocapid[b] >= 0:
                self.remarks.say("inferred", f"the mocap body {self.name('body', b)!r} is fixed", self.source)
        for array, (what, text) in NOT_READ.items():
            values = getattr(m, array, None)
            rows = [] if values is None else [i for i, row in enumerate(np.asarray(values)) if np.any(row)]
            for k in rows:
                self.refuse("joint" if what == "dof" else what, int(m.dof_jntid[k]) if what == "dof" else int(k), text)

    def _link(self, b: int) -> RobotLink:
        m, name = self.m, self.name("body", b)
        joints = range(int(m.body_jntadr[b]), int(m.body_jntadr[b]) + int(m.body_jntnum[b])) if m.body_jntnum[b] else ()
        moves = tuple(self._move(j) for j in joints)
        free = any(x.kind == "free" for x in moves)
        placement = Placement() if free else Placement(rotation_of(m.body_quat[b]), np.array(m.body_pos[b]))
        turn = rotation_of(m.body_iquat[b])
        inertia = turn @ np.diag(m.body_inertia[b]) @ turn.T
        inertia = np.where(np.abs(inertia) <= 1e-15 * np.abs(inertia).max(initial=0), 0, (inertia + inertia.T) / 2)
        return RobotLink(
            name, int(m.body_parentid[b]) - 1, placement, moves, float(m.body_mass[b]), np.array(m.body_ipos[b]), inertia,
            float(m.body_gravcomp[b]), self.where("body", name),
        )  # fmt: skip

    def _move(self, j: int) -> Move:
        m, name, kind = self.m, self.name("joint", j), JOINTS[int(self.m.jnt_type[j])]
        d, p = int(m.jnt_dofadr[j]), int(m.jnt_qposadr[j])
        single = kind in ("hinge", "slide")
        count = {"free": 6, "ball": 3}.get(kind, 1)
        for what, values in (("armature", m.dof_armature), ("damping", m.dof_damping)):
            if len(set(values[d : d + count].tolist())) > 1:
                self.refuse("joint", j, f"{what} that differs between directions")
        if not single and m.jnt_stiffness[j]:
            self.refuse("joint", j, f"a spring in a {kind} joint")
        if m.jnt_actgravcomp[j] and m.body_gravcomp.any() and (m.jnt_actfrclimited[j] or not len(m.actuator_trntype)):
            self.refuse("joint", j, "compensation of gravity by actuators, without actuators or with a limit")
        limited = bool(m.jnt_limited[j])
        if limited and not single:
            self.remarks.say("ignored", f"the limit of the {kind} joint {name!r}", self.where("joint", name))
        return Move(
            name,
            kind,
            np.array(m.jnt_axis[j]) if single else np.array([0.0, 0.0, 1.0]),
            np.array(m.jnt_pos[j]) if kind != "free" else np.zeros(3),
            float(m.qpos0[p]) if single else 0.0,
            (*m.qpos0[p + 3 : p + 7].tolist(), *m.qpos0[p : p + 3].tolist()) if kind == "free" else (),
            float(m.dof_armature[d]),
            float(m.dof_damping[d]),
            float(m.dof_frictionloss[d : d + count].max()),
            float(m.jnt_stiffness[j]) if single else 0.0,
            float(m.qpos_spring[p]) if single else 0.0,
            tuple(m.jnt_range[j].tolist()) if limited and single else None,
            tuple(m.jnt_actfrcrange[j].tolist()) if m.jnt_actfrclimited[j] else None,
            where=self.where("joint", name),
        )

    # Ties ----------------------------------------------------------------------------------------------------------

    def _equalities(self) -> tuple[list[Coupling], tuple[Closure, ...]]:
        m = self.m
        couplings, closures = list[Coupling](), list[Closure]()
        for k in range(m.neq):
            name, kind = self.name("equality", k), int(m.eq_type[k])
            where = self.where("equality", name)
            if not m.eq_active0[k]:
                self.remarks.say("ignored", f"the equality {name!r}, which is not active", where)
            elif kind in (CONNECT, WELD):
                closures.append(self._closure(k, kind, name, where))
            elif kind in (JOINT, TENDON):
                couplings.append(self._coupling(k, kind, name, where))
            else:
                self.refuse("equality", k, "a constraint of a flexible body")
                continue
            if m.eq_active0[k]:
                self.remarks.say("inferred", f"the equality {name!r} is soft in MuJoCo, and exact in kane", where)
        return couplings, tuple(closures)

    def _closure(self, k: int, kind: int, name: str, where: str) -> Closure:
        m, data = self.m, self.m.eq_data[k]
        a, b = int(m.eq_obj1id[k]), int(m.eq_obj2id[k])
        label: Any = "connect" if kind == CONNECT or not data[10] else "weld"  # torque scale 0: rotation is free
        if int(m.eq_objtype[k]) == OBJECTS["site"]:
            sides = [Placement(rotation_of(m.site_quat[s]), np.array(m.site_pos[s])) for s in (a, b)]
            a, b = int(m.site_bodyid[a]), int(m.site_bodyid[b])
        elif kind == CONNECT:
            sides = [Placement(offset=np.array(data[0:3])), Placement(offset=np.array(data[3:6]))]
        else:
            sides = [Placement(rotation_of(data[6:10]), np.array(data[3:6])), Placement(offset=np.array(data[0:3]))]
        return Closure(name, label, a - 1, b - 1, sides[0], sides[1], where)

    def _coupling(self, k: int, kind: int, name: str, where: str) -> Coupling:
        m, ids = self.m, (int(self.m.eq_obj1id[k]), int(self.m.eq_obj2id[k]))
        what: Any = "joint" if kind == JOINT else "tendon"
        zeros = [m.qpos0[m.jnt_qposadr[i]] if kind == JOINT else m.tendon_length0[i] for i in ids if i >= 0]
        names = [self.name(what, i) if i >= 0 else "" for i in ids]
        polynomial = [float(c) for c in m.eq_data[k][: 5 if names[1] else 1]]
        while len(polynomial) > 1 and not polynomial[-1]:
            polynomial.pop()
        return Coupling(name, what, names[0], names[1], tuple(polynomial), (float(zeros[0]), float(zeros[-1])), where)

    def _strand(self, k: int) -> Strand | None:
        m, name = self.m, self.name("tendon", k)
        at = range(int(m.tendon_adr[k]), int(m.tendon_adr[k]) + int(m.tendon_num[k]))
        kinds = {int(m.wrap_type[i]) for i in at}
        if kinds == {SITE_WRAP}:
            sites = [int(m.wrap_objid[i]) for i in at]
            points = tuple((int(m.site_bodyid[s]) - 1, np.array(m.site_pos[s])) for s in sites)
            arms: dict[str, float] = {}
        elif kinds == {JOINT_WRAP}:
            points, arms = (), {}
            for i in at:
                joint = self.name("joint", m.wrap_objid[i])
                arms[joint] = arms.get(joint, 0.0) + float(m.wrap_prm[i])
        else:
            self.refuse("tendon", k, "pulleys, or wrapping around geoms")
            return None
        low, high = m.tendon_range[k].tolist() if m.tendon_limited[k] else (-np.inf, np.inf)
        return Strand(
            name, points, MappingProxyType(arms), (low, high), float(m.tendon_stiffness[k]), float(m.tendon_damping[k]),
            (float(m.tendon_lengthspring[k][0]), float(m.tendon_lengthspring[k][1])), self.where("tendon", name),
        )  # fmt: skip

    # Actuators -----------------------------------------------------------------------------------------------------

    def _drive(self, k: int, strands: tuple[Strand, ...]) -> Actuation | None:
        library, m, name = mujoco(), self.m, self.name("actuator", k)
        kinds = {
            "transmission": (m.actuator_trntype[k], library.mjtTrn, ("JOINT", "JOINTINPARENT", "TENDON")),
            "dynamics": (m.actuator_dyntype[k], library.mjtDyn, tuple(RATES)),
            "gain": (m.actuator_gaintype[k], library.mjtGain, ("FIXED", "AFFINE")),
            "bias": (m.actuator_biastype[k], library.mjtBias, ("NONE", "AFFINE")),
        }
        own: dict[str, str] = {}
        for what, (value, table, known) in kinds.items():
            own[what] = table(int(value)).name.partition("_")[2]
            if own[what] not in known:
                self.refuse("actuator", k, f"{what} {own[what].lower()}")
                return None
        driven, along = int(m.actuator_trnid[k][0]), own["transmission"] == "TENDON"
        if along and self.name("tendon", driven) not in {s.name for s in strands}:
            self.refuse("actuator", k, "it acts on a tendon that is not imported")
            return None
        if not along and JOINTS[int(m.jnt_type[driven])] not in ("hinge", "slide"):
            self.refuse("actuator", k, f"it drives a {JOINTS[int(m.jnt_type[driven])]} joint")
            return None
        (g0, g1, g2), (b0, b1, b2) = (x[k][:3].tolist() for x in (m.actuator_gainprm, m.actuator_biasprm))
        return Actuation(
            name, "" if along else self.name("joint", driven), self.name("tendon", driven) if along else "",
            float(m.actuator_gear[k][0]),
            (g0, g1, g2) if own["gain"] == "AFFINE" else (g0, 0.0, 0.0),
            (b0, b1, b2) if own["bias"] == "AFFINE" else (0.0, 0.0, 0.0),
            tuple(m.actuator_forcerange[k].tolist()) if m.actuator_forcelimited[k] else None,
            RATES[own["dynamics"]], float(m.actuator_dynprm[k][0]), self.where("actuator", name),
        )  # fmt: skip

    def _shapes(self) -> Iterator[LinkShape]:
        m = self.m
        for g in range(m.ngeom):
            kind = SHAPES[int(m.geom_type[g])]
            s = m.geom_size[g].tolist()
            size = {
                "sphere": (s[0],),
                "capsule": (s[0], 2 * s[1]),
                "cylinder": (s[0], 2 * s[1]),
                "box": tuple(2 * x for x in s),
                "ellipsoid": tuple(s),
                "plane": tuple(s[:2]),
            }.get(kind, ())
            mesh = self.name("mesh", m.geom_dataid[g]) if kind == "mesh" else ""
            collides = bool(m.geom_contype[g] or m.geom_conaffinity[g])
            yield LinkShape(
                self.name("body", m.geom_bodyid[g]), "collision" if collides else "visual", kind, size,
                tuple(map(tuple, rotation_of(m.geom_quat[g]).tolist())), tuple(m.geom_pos[g].tolist()), mesh,
                tuple(m.geom_rgba[g].tolist()),
            )  # fmt: skip


MEMORY = 4 * 2**30
"""Maximum address space of the reading process in bytes."""
INCLUDES = 100
REFUSED = ("plugin", "flexcomp", "flex", "deformable")
"""Elements that are not rigid bodies, or that run code."""
_CHILD = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except (ImportError, ValueError, OSError):
    pass
import mujoco
try:
    model = mujoco.MjModel.from_xml_path(sys.argv[1])
    mujoco.mj_saveModel(model, sys.argv[2], None)
except Exception as error:
    sys.stderr.write("\\n" + str(error)[:2000])
    sys.exit(3)
"""


def mujoco() -> Any:
    """The mujoco package."""
    lacking = ModelError("Expected the package mujoco to read MJCF. Install it: pip install 'kane[models]'.")
    return expect.package("mujoco", lacking)


def read(source: Any, folder: Any, timeout: float) -> tuple[Any, Element]:
    """MuJoCo's compiled model, and the text as elements.

    Raises
    ------
    ModelError
        if a named file is outside the folder, or MuJoCo cannot read the text within the bounds on time and memory
    """
    package = mujoco()
    expect.that(expect.is_number(timeout) and timeout > 0, "timeout= as seconds above zero", timeout)
    text, name, path = given(source, "MJCF")
    root = parsed(text, name)
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise root.wrong("<mujoco> as the root of an MJCF", f"<{cut(root.tag)}>")
    within = _folder(path, folder)
    _check(root, path, within)
    with tempfile.TemporaryDirectory(prefix="kane-mjcf-") as own:
        if path is None:
            path = Path(own) / "model.xml"
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        binary = Path(own) / "model.mjb"
        _run(path, binary, min(timeout, _WEEK), name)
        return package.MjModel.from_binary_path(str(binary)), root


_UNSEEN = {"MUJOCO_GL": "disable"}
"""No library for windows, whose import takes as long as that of MuJoCo."""
_WEEK = 604800.0
"""Maximum timeout in seconds; operating systems do not accept much longer ones."""


def _run(path: Path, binary: Path, timeout: float, name: str) -> None:
    """Runs the process that reads the text and writes MuJoCo's binary model."""
    command = [sys.executable, "-I", "-c", _CHILD.format(memory=MEMORY), str(path.absolute()), str(binary)]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=timeout, check=False,
            cwd=binary.parent, env={k: v for k, v in os.environ.items() if not k.startswith("MUJOCO")} | _UNSEEN,
        )  # fmt: skip
    except subprocess.TimeoutExpired as late:
        cure = "Give a longer timeout=, or a smaller model."
        raise expect.refusal(ModelError, f"MuJoCo to read {name} in {timeout:g} s", "more", cure) from late
    if done.returncode or not binary.is_file():
        lines = [x.strip() for x in done.stderr.decode(errors="replace").splitlines() if x.strip()]
        came = cut("; ".join(lines[-4:]) or f"exit status {done.returncode}", 300)
        raise ModelError(f"Expected an MJCF that MuJoCo reads, got: {came} ({name})")


def _folder(path: Path | None, folder: Any) -> Path | None:
    if folder is None:
        return None if path is None else path.resolve().parent
    expect.instance(folder, (str, Path), "folder= the path of a folder")
    result = Path(folder).resolve()
    expect.that(result.is_dir(), "folder= the path of a folder", str(folder))
    return result


def _check(root: Element, path: Path | None, within: Path | None) -> None:
    """Raises if a named file, also in includes, is outside the folder, or an element runs code."""
    waiting, seen = [root], set[Path]() if path is None else {path.resolve()}
    elements: list[Element] = []
    while waiting:
        for e in waiting.pop().walk():
            if e.tag in REFUSED:
                raise e.wrong("rigid bodies alone, and no plugins", f"<{e.tag}>", "Leave it out.")
            elements.append(e)
            if e.tag != "include":
                continue
            (found,) = _files(e, "file", [""], path, within)
            if found in seen or len(seen) > INCLUDES:
                came = f"{found.name!r} again" if found in seen else f"more than {INCLUDES}"
                raise e.wrong("files that are included once", came)
            seen.add(found)
            text, name, _ = given(found, "MJCF")
            waiting.append(parsed(text, name))
    folders = ["", *(v for e in elements if e.tag == "compiler" for k, v in e.attributes.items() if k.endswith("dir"))]
    for e in elements:
        for key in [k for k in e.attributes if k.startswith("file") and e.tag != "include"]:
            _files(e, key, folders, path, within)


def _files(e: Element, key: str, folders: list[str], path: Path | None, within: Path | None) -> list[Path]:
    """The files that an attribute may name, in any of these folders."""
    name = e.text(key)
    if path is None or within is None:
        raise e.wrong("no files in an MJCF that is given as text", cut(repr(name)), "Give the path of a file.")
    result = []
    for folder in folders:
        for p in (folder, name):
            if PurePosixPath(p).is_absolute() or PureWindowsPath(p).drive or "\0" in p:
                raise e.wrong(f"files below {within.name!r}", cut(repr(p)), "Name it relative to the model.")
        file = (path.resolve().parent / folder / name).resolve()
        if within not in file.parents:
            cure = "Say by folder= below which folder files may be opened."
            raise e.wrong(f"files below {within.name!r}", cut(repr(str(PurePosixPath(folder, name)))), cure)
        result.append(file)
    return result
