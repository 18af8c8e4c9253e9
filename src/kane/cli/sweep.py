# SPDX-License-Identifier: BSD-3-Clause
"""`kane sweep`: motions for a design of experiments, written to a store; a second call continues an interrupted one."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.derive import derived
from kane.cli.models import AsJson, Inputs, Name, NamedModel, Parameters, Q, States, U, model_of
from kane.cli.screen import Misuse, user_code
from kane.cli.simulate import NamedStart, check_complete, declared_start
from kane.errors import alike, cut

_TOGETHER = 2**16
"""Number of instances whose causes are read at a time."""
_CAUSES = 10
_NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(e[-+]?\d+)?")
"""Numbers in causes; causes that differ only in these count as one."""


def sweep(
    name: Name,
    store: Annotated[Path, typer.Option("--store", help="Folder for the results, in the format Zarr 3.")],
    design: Annotated[
        list[str],
        typer.Option(
            "--design",
            metavar="NAME=LOW:HIGH",
            help="Bounds of a coordinate, speed, parameter, input or state; with --sampler product, levels NAME=A,B,C.",
        ),
    ],
    sampler: Annotated[str, typer.Option(help="sobol, latin, halton, uniform, or product.")] = "sobol",
    count: Annotated[int | None, typer.Option(help="Number of instances.", show_default=False)] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the random numbers.", show_default=False)] = None,
    span: Annotated[
        tuple[float, float] | None, typer.Option(help="Start and end times, s.", show_default="SPAN")
    ] = None,
    samples: Annotated[int, typer.Option(help="Samples of each motion.")] = 501,
    method: Annotated[str | None, typer.Option(help="Integrator.", show_default="auto")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads.", show_default="all processors")] = None,
    chunk: Annotated[
        int | None, typer.Option(help="Number of instances per chunk of the store.", show_default=False)
    ] = None,
    q: Q = None,
    u: U = None,
    parameter: Parameters = None,
    input: Inputs = None,
    state: States = None,
    as_json: AsJson = False,
) -> None:
    """Simulate MODEL once for each instance of a design; leave with 1 if none gets to its end.

    Called again with the same options and the same store, also after it was killed, it runs what is missing.
    """
    model = model_of(name)
    eom = derived(model)
    told = {"q": q, "u": u, "parameters": parameter, "inputs": input, "states": state}
    drawn = _design(design, sampler, eom)
    with user_code(model.path, "START"):
        begin = _without(declared_start(model, eom, told), drawn, ("--q", "--u") if eom.system.constraints else ())
        runs = kn.simulate_many(
            eom, span or model.span, **begin, design=drawn, sampler=sampler, count=count, seed=seed, samples=samples,
            method=method, threads=threads, chunk=chunk, store=store,
        )  # fmt: skip
    what = _summary(model, runs, store)
    if as_json:
        screen.as_json(what)
    else:
        _show(what)
    raise typer.Exit(0 if what["statuses"].keys() & {"finished", "event"} else 1)


def _design(texts: Sequence[str], sampler: str, eom: kn.Equations) -> dict[str, list[float]]:
    """Bounds or levels by name."""
    sign, form = (",", "NAME=A,B,C") if sampler == "product" else (":", "NAME=LOW:HIGH")
    symbols = [*eom.coordinates, *eom.speeds, *eom.states, *eom.parameters, *eom.inputs]
    names, result = [s.name for s in symbols], dict[str, list[float]]()
    for text in texts:
        name, _, values = (part.strip() for part in text.partition("="))
        try:
            numbers = [float(value) for value in values.split(sign)]
        except ValueError:
            raise Misuse(f"Expected --design {form} with numbers for the sampler {sampler}, got {text!r}.") from None
        if name not in names:
            raise Misuse(f"Expected --design of a quantity of the model, got {name!r}.{alike(name, names)}")
        if name in result:
            raise Misuse(f"Expected one --design for each name, got {name} twice.")
        result[name] = numbers
    return result


def _without(begin: NamedStart, design: Mapping[str, Any], solved: tuple[str, ...]) -> dict[str, Any]:
    """Values common to all instances by kind; raises Misuse for missing values, unless constraints determine them (`solved`)."""
    missing = [option for option in begin.missing if option.split()[1].removesuffix("=…") not in design]
    check_complete([option for option in missing if not option.startswith(solved)])
    return {kind: {s: v for s, v in own.items() if s not in design} or None for kind, own in begin.values.items()}


def _summary(model: NamedModel, runs: Any, store: Path) -> dict[str, Any]:
    """Numbers of instances by status and cause, as data for JSON, read in blocks; causes that differ in numbers have one example."""
    statuses: Counter[str] = Counter()
    causes: Counter[tuple[str, str]] = Counter()
    examples: dict[tuple[str, str], str] = {}
    count = runs.sizes["instance"]
    for k in range(0, count, _TOGETHER):
        some = runs.isel(instance=slice(k, k + _TOGETHER))
        for (status, cause), n in Counter(
            zip(some.status.values.tolist(), some.cause.values.tolist(), strict=True)
        ).items():
            key = status, _NUMBER.sub("#", cause)
            statuses[status] += n
            causes[key] += n
            examples.setdefault(key, cause)
    told = [{"status": kind[0], "cause": examples[kind], "count": n} for kind, n in causes.most_common()]
    return {
        "model": model.name,
        "store": str(store),
        "instances": count,
        "statuses": dict(statuses.most_common()),
        "causes": [one for one in told if one["status"] != "finished"],
    }


def _show(what: Mapping[str, Any]) -> None:
    ends = ", ".join(f"{n} {status}" for status, n in what["statuses"].items())
    screen.say(f"{what['instances']} instances: {ends}.")
    causes = what["causes"]
    if causes:
        screen.heading("Causes")
        screen.table([(str(one["count"]), one["status"], cut(one["cause"], 200)) for one in causes[:_CAUSES]])
    if len(causes) > _CAUSES:
        typer.echo(f"  … and {len(causes) - _CAUSES} others")
    typer.echo(f"Store: {what['store']}")
