# SPDX-License-Identifier: BSD-3-Clause
"""S-functions of Simulink, built against a header with as much of `simstruc.h` as they use, and run by a master in C."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums
from tests.program.programs import compiler

HEADER = """\
#include <stddef.h>
#include <stdio.h>
typedef int int_T;
typedef double real_T;
typedef const real_T *const *InputRealPtrsType;
typedef struct { double *values; size_t count; } mxArray;
typedef struct {
    mxArray given[2];
    double t, x[16], dx[16], work[512], out[2][16], in[8];
    const double *wires[8];
    int states, parameters, inputs, outputs, feeds, rwork, widths[2], width;
    const char *error;
} SimStruct;
#define CONTINUOUS_SAMPLE_TIME 0.0
#define ssGetT(S) ((S)->t)
#define ssGetContStates(S) ((S)->x)
#define ssGetdX(S) ((S)->dx)
#define ssGetRWork(S) ((S)->work)
#define ssGetSFcnParam(S, k) (&(S)->given[k])
#define mxIsEmpty(a) ((a)->count == 0)
#define mxGetPr(a) ((a)->values)
#define mxGetNumberOfElements(a) ((a)->count)
#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) 2
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssSetNumContStates(S, n) ((S)->states = (n))
#define ssSetNumInputPorts(S, n) ((S)->inputs = (n), 1)
#define ssSetInputPortWidth(S, k, n) ((S)->width = (n))
#define ssSetInputPortDirectFeedThrough(S, k, n) ((S)->feeds = (n))
#define ssSetNumOutputPorts(S, n) ((S)->outputs = (n), 1)
#define ssSetOutputPortWidth(S, k, n) ((S)->widths[k] = (n))
#define ssSetNumSampleTimes(S, n) ((void)(n))
#define ssSetNumRWork(S, n) ((S)->rwork = (n))
#define ssSetSampleTime(S, k, t) ((void)(S))
#define ssSetOffsetTime(S, k, t) ((void)(S))
#define ssGetInputPortRealSignalPtrs(S, k) ((S)->wires)
#define ssGetOutputPortRealSignal(S, k) ((S)->out[k])
"""
MASTER = """\
static void step(SimStruct *S, double h)  /* Runge and Kutta's */
{
    static const double at[4] = {0, 0.5, 0.5, 1}, share[4] = {1, 2, 2, 1};
    double x[16], t = S->t, sum[16] = {0};
    int j, k;
    for (k = 0; k < S->states; k++) x[k] = S->x[k];
    for (j = 0; j < 4; j++) {
        for (k = 0; k < S->states; k++) S->x[k] = x[k] + at[j]*h*S->dx[k];
        S->t = t + at[j]*h;
        mdlDerivatives(S);
        for (k = 0; k < S->states; k++) sum[k] += share[j]*S->dx[k];
    }
    for (k = 0; k < S->states; k++) S->x[k] = x[k] + h/6*sum[k];
}

int main(int argc, char **argv)
{
    static SimStruct own, *S = &own;
    double x[] = {@X@}, p[] = {@P@}, r[] = {@R@};
    int k;
    (void)argv;
    own.given[0] = (mxArray){p, argc > 1 ? (size_t)argc - 2 : 0};
    own.given[1] = (mxArray){x, sizeof x/sizeof *x};
    own.t = 0.3;
    for (k = 0; k < 8; k++) own.wires[k] = &own.in[k];
    mdlInitializeSizes(S);
    if (own.error) return puts(own.error), 1;
    for (k = 0; k < own.width; k++) own.in[k] = r[k];
    mdlInitializeSampleTimes(S);
    mdlStart(S);
    mdlInitializeConditions(S);
    mdlDerivatives(S);
    mdlOutputs(S, 0);
    for (k = 0; k < own.states; k++) printf("%.17g\\n", own.dx[k]);
    for (k = 0; k < own.widths[0]; k++) printf("%.17g\\n", own.out[0][k]);
    for (k = 0; k < own.widths[1]; k++) printf("%.17g\\n", own.out[1][k]);
    for (k = 0; k < @STEPS@; k++) step(S, @H@);
    for (k = 0; k < own.states; k++) printf("%.17g\\n", own.x[k]);
    mdlTerminate(S);
    return own.rwork > 512;
}
"""

SPAN = 0.5


@pytest.fixture
def master(tmp_path):
    """(what a master got, from how many parameters are given; equations; x, p, r)."""
    F = kn.input("F", "N")
    eom = driven(F)
    compiled = eom.compile(name="model", outputs={"push": F * eom.speeds[0], "both": list(eom.coordinates)})
    rng = np.random.default_rng(3)
    x, p, r = (rng.uniform(0.5, 1.5, len(s)) for s in (eom.state, eom.parameters, eom.inputs))
    text = MASTER
    text = text.replace("@STEPS@", "2000").replace("@H@", repr(SPAN / 2000))
    for mark, values in {"@X@": x, "@P@": p, "@R@": r}.items():
        text = text.replace(mark, ", ".join(map(repr, values.tolist())))
    (tmp_path / "simstruc.h").write_text(HEADER)
    (tmp_path / "cg_sfun.h").write_text(text)
    (tmp_path / "model_sfun.c").write_text(compiled.emit("sfunction", ["rhs", "outputs"]))
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-I", str(tmp_path)]
    subprocess.run([compiler(), *flags, "-o", "model", "model_sfun.c", "-lm"], cwd=tmp_path, check=True, timeout=300)

    def run(given: int | None) -> subprocess.CompletedProcess[str]:
        count = [] if given is None else [""] * (given + 1)
        return subprocess.run(
            [str(Path(tmp_path) / "model"), *count], capture_output=True, text=True, check=False, timeout=60
        )

    return run, eom, compiled, x, p, r


def driven(F):
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    s, theta = kn.coordinates("s theta")
    v, w = kn.speeds("v w")
    m1, m2, l = (kn.parameter(*row) for row in [("m1", 1.0, "kg"), ("m2", 0.3, "kg"), ("l", 0.5, "m")])
    C = O.at("C", s * N.x)
    B = C.at("B", -l * N.rotate("A", theta, N.z).y)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(C, F * N.x)]
    bodies = [kn.Particle("cart", C, m1), kn.Particle("bob", B, m2)]
    return kn.derive(kn.System(N, bodies=bodies, speeds={v: s.dt, w: theta.dt}, loads=loads))


def test_derivatives_outputs_and_the_motion_are_those_of_machine_code(master):
    run, eom, compiled, x, p, r = master
    for given in (None, len(p)):
        found = [float(line) for line in run(given).stdout.split()]
        own = compiled.outputs(0.3, x, None if given is None else p, r)
        rates = compiled.rhs(0.3, x, None if given is None else p, r)
        expected = [*rates, *x, own["push"], *own["both"]]
        np.testing.assert_allclose(found[: -len(x)], expected, rtol=1e-13)
        values = {} if given is None else {"parameters": dict(zip(eom.parameters, p, strict=True))}
        start = {"q": x[:2], "u": x[2:], "inputs": dict(zip(eom.inputs, r, strict=True))}
        sol = kn.simulate(eom, (0.3, 0.3 + SPAN), rtol=1e-12, atol=1e-12, **start, **values)
        np.testing.assert_allclose(found[-len(x) :], sol.states[-1], rtol=1e-9)


def test_another_number_of_parameters_is_told(master):
    run, *_, p, _ = master
    assert run(len(p) - 1).stdout.strip() == f"Expected {len(p)} values of parameters, or [] for the defaults."


def test_what_an_s_function_cannot_hold():
    compiled = kn.derive(pendulums.system(2)).compile()
    with pytest.raises(kn.ArgumentError, match='Expected "rhs" with "outputs" at most for an S-function, got forcing'):
        compiled.emit("sfunction", "forcing")
