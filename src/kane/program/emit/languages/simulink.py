# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a Simulink S-function: a level-2 C MEX file with the equations in C and the functions that Simulink calls."""

from kane.errors import ArgumentError
from kane.program.emit.c import CFile, CFunction, c_file, emit_c
from kane.program.emit.identifiers import made_by
from kane.program.program import Program

_GIVEN = {"t": "ssGetT(S)", "x": "ssGetContStates(S)", "p": "p", "r": "r", "h": "ssGetRWork(S)"}
_HEAD = """\
/*
 * {name}_sfun.c: an S-function of Simulink, level 2. {made}
 *
 * Build:    mex {name}_sfun.c   in MATLAB
 * Use:      the block "S-Function" of the name {name}_sfun. Its parameters are the values of the {parameters}, [] for the
 *           defaults, and the initial state. Input: {inputs}. Outputs: the state{outputs}.
 *
 * What follows is the file in C, and at its end what Simulink calls.
 */
"""
_TEXT = """\
#define S_FUNCTION_NAME {name}_sfun
#define S_FUNCTION_LEVEL 2
#include "simstruc.h"

static void kane_parameters(SimStruct *S, double *p)
{{
    const mxArray *given = ssGetSFcnParam(S, 0);
    size_t k;
    for (k = 0; k < {np}; k++) p[k] = mxIsEmpty(given) ? {defaults} : mxGetPr(given)[k];
}}

static void kane_inputs(SimStruct *S, double *r)
{{
{read}
}}

static void mdlInitializeSizes(SimStruct *S)
{{
    ssSetNumSFcnParams(S, 2);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) return;
    if (!mxIsEmpty(ssGetSFcnParam(S, 0)) && mxGetNumberOfElements(ssGetSFcnParam(S, 0)) != {np}) {{
        ssSetErrorStatus(S, "Expected {np} values of parameters, or [] for the defaults.");
        return;
    }}
    if (mxGetNumberOfElements(ssGetSFcnParam(S, 1)) != {nx}) {{
        ssSetErrorStatus(S, "Expected {nx} values of the initial state.");
        return;
    }}
    ssSetNumContStates(S, {nx});
    if (!ssSetNumInputPorts(S, {ports_in})) return;
{port_in}    if (!ssSetNumOutputPorts(S, {ports_out})) return;
    ssSetOutputPortWidth(S, 0, {nx});
{port_out}    ssSetNumSampleTimes(S, 1);
    ssSetNumRWork(S, {nh});
}}

static void mdlInitializeSampleTimes(SimStruct *S)
{{
    ssSetSampleTime(S, 0, CONTINUOUS_SAMPLE_TIME);
    ssSetOffsetTime(S, 0, 0.0);
}}

#define MDL_PROCESS_PARAMETERS
static void mdlProcessParameters(SimStruct *S)
{{
    double p[{np} + 1];
    kane_parameters(S, p);
    {hoist}({hoisted});
}}

#define MDL_START
static void mdlStart(SimStruct *S)
{{
    mdlProcessParameters(S);
}}

#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S)
{{
    size_t k;
    for (k = 0; k < {nx}; k++) ssGetContStates(S)[k] = mxGetPr(ssGetSFcnParam(S, 1))[k];
}}

static void mdlOutputs(SimStruct *S, int_T tid)
{{
    size_t k;
    (void)tid;
    for (k = 0; k < {nx}; k++) ssGetOutputPortRealSignal(S, 0)[k] = ssGetContStates(S)[k];
{shown}}}

#define MDL_DERIVATIVES
static void mdlDerivatives(SimStruct *S)
{{
{rates}}}

static void mdlTerminate(SimStruct *S)
{{
    (void)S;
}}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
"""


def emit_simulink(program: Program, *, contract: bool = True, version: str = "") -> str:
    """The text of `<name>_sfun.c`: "rhs" gives the derivatives; "outputs", if present, is the second output port.

    Raises
    ------
    ArgumentError
        if there is no right-hand side, or a routine has a port other than t, x, p and r
    """
    ports = {port.name: port for port in program.ports}
    routines = {r.name for r in program.routines}
    if "rhs" not in routines or ports.keys() != {"t", "x", "p", "r"}:
        got = ", ".join(sorted(routines))
        raise ArgumentError(
            f'Expected "rhs" with "outputs" at most for an S-function, got {got}. Leave the others out.'
        )
    file = c_file(program)
    functions = {f.function.name: f for f in file.functions[1:]}
    shown, hoist = functions.get("outputs"), file.functions[0]
    nr, table = len(ports["r"].symbols), {port.name: name for port, name, _ in file.tables}
    size = shown.size if shown else ""
    head = _HEAD.format(
        made=made_by(version),
        name=file.prefix,
        parameters=ports["p"].nouns,
        inputs=f"the {nr} inputs" if nr else "none",
        outputs=", then what was named to be an output" if shown else "",
    )
    own = _TEXT.format(
        name=file.prefix,
        np=len(ports["p"].symbols),
        nx=len(ports["x"].symbols),
        nh=hoist.size,
        defaults=f"{table['p']}[k].value",
        read=_READ.format(nr=nr) if nr else "    (void)S, (void)r;",
        ports_in=int(nr > 0),
        port_in=_IN.format(nr=nr, feeds=int(shown is not None)) if nr else "",
        ports_out=1 + (shown is not None),
        port_out=f"    ssSetOutputPortWidth(S, 1, {size});\n" if shown else "",
        hoist=hoist.name,
        hoisted=_passed(file, hoist, ""),
        shown=_called(file, shown, "ssGetOutputPortRealSignal(S, 1)", nr) if shown else "",
        rates=_called(file, functions["rhs"], "ssGetdX(S)", nr),
    )
    return f"{head}{emit_c(program, contract=contract, version=version)}\n{own}"


_READ = """\
    InputRealPtrsType given = ssGetInputPortRealSignalPtrs(S, 0);
    size_t k;
    for (k = 0; k < {nr}; k++) r[k] = *given[k];"""
_IN = """\
    ssSetInputPortWidth(S, 0, {nr});
    ssSetInputPortDirectFeedThrough(S, 0, {feeds});
"""


def _called(file: CFile, f: CFunction, out: str, inputs: int) -> str:
    """A block that calls a routine at the current state."""
    parameters = len(file.program.port("p").symbols)
    return f"""    {{
        double p[{parameters} + 1], r[{inputs} + 1];
        kane_parameters(S, p);
        kane_inputs(S, r);
        {f.name}({_passed(file, f, out)});
    }}
"""


def _passed(file: CFile, f: CFunction, out: str) -> str:
    given = {file.names.arguments[port.name]: _GIVEN[port.name] for port in file.program.ports} | {"h": _GIVEN["h"]}
    return ", ".join(given.get(name, out) for name in f.arguments)
