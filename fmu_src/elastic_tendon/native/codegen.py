"""CasADi to C: the generated part of the library, behind the narrow waist `native/runtime/model.h`.

Every function is scalar-expanded (SX), works on caller's memory and needs libm only. The
Jacobians are taken with respect to the stacked vector v = [x; u; p] and stored as the nonzeros
of a compressed-column pattern, which the runtime multiplies with directions.
"""

import re
from collections.abc import Iterable

import casadi as ca

from elastic_tendon.actuator.system import (
    HybridSystem,
    derivative_of_unknowns,
    newton_step,
    total_jacobian,
)
from elastic_tendon.actuator.variables import POSITION_OF
from elastic_tendon.effects.symbolic import one_at_a_time

_PATTERN = """\
static const Pattern {name}_pattern = {{
  (const int[]){{{columns}}},
  (const int[]){{{rows}}}
}};
"""

_WRAPPER = """\
static inline void model_{name}({signature}) {{
{prepare}  const double* arg[] = {{{arguments}}};
  double* res[] = {{{result}}};
  casadi_{name}(arg, res, 0, 0, 0);
}}
"""

# functions of the unknowns of implicit equations find these first; see native/runtime/implicit.h
_SOLVE = "  double w[N_UNKNOWNS];\n  solve_implicit(x, u, p, r, w);\n"
_FOLLOW = "  double w_by_v[N_UNKNOWNS_BY_V];\n  model_unknowns_by_v(x, u, p, r, w, w_by_v);\n"
_OF_UNKNOWNS = ("guess", "newton", "unknowns_by_v")


def _c_list(values: Iterable[object]) -> str:
    """Initialiser of a C array, never empty (C99 has no empty arrays)."""
    return ", ".join(str(value) for value in values) or "0"


def _functions(system: HybridSystem) -> dict[str, ca.Function]:
    """CasADi functions by the name that the runtime calls, without their ``model_`` prefix."""
    x, u, p, r, w = system.x, system.u, system.p, system.r, system.w
    v = ca.vertcat(x, u, p)
    unknowns_by_v = derivative_of_unknowns(system.residuals, w, v)
    w_by_v = ca.SX.sym("w_by_v", unknowns_by_v.sparsity())
    at = {"x": x, "u": u, "p": p, "r": r}
    after = at | {"r_next": system.r_next}
    solved = at | ({"w": w} if w.numel() else {})
    followed = solved | ({"w_by_v": _nonzeros(w_by_v)} if w.numel() else {})

    def by_v(expression: ca.SX) -> ca.SX:
        return total_jacobian(expression, v, w, w_by_v)

    rates_jacobian = by_v(system.rates)
    of_unknowns = {
        "guess": (at, system.guesses),
        "newton": (solved, newton_step(w, system.residuals)),
        "unknowns_by_v": (solved, _nonzeros(unknowns_by_v)),
    }
    expressions = (of_unknowns if w.numel() else {}) | {
        "rates": (solved, system.rates),
        "outputs": (solved, system.outputs),
        "indicators": (solved, system.indicators),
        "next_modes": (solved, system.next_modes),
        "reset": (after, system.reset),
        "starts": (solved, system.starts),
        "delay": (at, system.delay),
        "rates_by_state": (followed, ca.densify(rates_jacobian[:, : x.numel()])),
        "rates_jacobian": (followed, rates_jacobian),
        "outputs_jacobian": (followed, by_v(system.outputs)),
        "indicators_jacobian": (followed, by_v(system.indicators)),
        "reset_jacobian": (after, ca.jacobian(system.reset, v)),
        "starts_jacobian": (followed, by_v(system.starts)),
        "delay_jacobian": (at, ca.jacobian(system.delay, v)),
    }
    return _compiled(expressions, p)


def _nonzeros(matrix: ca.SX) -> ca.SX:
    """As a column."""
    return ca.SX(ca.Sparsity.dense(matrix.nnz(), 1), matrix.nz[:])


def _compiled(
    expressions: dict[str, tuple[dict[str, ca.SX], ca.SX]], p: ca.SX
) -> dict[str, ca.Function]:
    """Functions of named arguments, with what depends on parameters alone taken out.

    That is evaluated once, by `prepare`, and stands behind the parameters in `p`.
    """
    given, rates = expressions["rates"]
    rates, reciprocals, divisors = _without_division(rates, given)
    compiled = [expression for _, expression in (expressions | {"rates": (given, rates)}).values()]
    known = ca.vertcat(p, reciprocals)
    reduced, symbols, constants = ca.extract_parametric(compiled, known, {})
    constants = [ca.substitute(constant, reciprocals, 1.0 / divisors) for constant in constants]
    prepared = ca.SX.sym("p", known.numel() + len(symbols))
    names = [known, *symbols]
    values = [prepared[: known.numel()], *ca.vertsplit(prepared[known.numel() :])]
    functions = {
        "prepare": ca.Function(
            "casadi_prepare", [p], [ca.vertcat(1.0 / divisors, *constants)], ["p"], ["result"]
        )
    }
    for (name, (given, _)), expression in zip(expressions.items(), reduced, strict=True):
        arguments = given | {"p": prepared}
        (expression,) = ca.substitute([expression], names, values)
        functions[name] = ca.Function(
            f"casadi_{name}", list(arguments.values()), [expression], list(arguments), ["result"]
        )
    return functions


def _without_division(rates: ca.SX, given: dict[str, ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Rates that multiply by symbols where they divided by what depends on parameters alone.

    Each stage of the solver waits for the rates of the one before, and most of that for a
    division by the inertia.

    Returns
    -------
    the rates; the symbols, columns; what each is the reciprocal of, a function of `p`
    """
    names = list(given)
    function = ca.Function("rates", list(given.values()), [rates])
    work: dict[int, tuple[ca.SX, bool]] = {}  # value, and whether it depends on p alone
    symbols: list[ca.SX] = []
    divisors: list[ca.SX] = []
    result = ca.SX(rates)
    for k in range(function.n_instructions()):
        operation, taken = function.instruction_id(k), function.instruction_input(k)
        made = function.instruction_output(k)
        if operation == ca.OP_INPUT:
            name = names[taken[0]]
            work[made[0]] = given[name].nz[taken[1]], name == "p"
        elif operation == ca.OP_CONST:
            work[made[0]] = ca.SX(function.instruction_constant(k)), True
        elif operation == ca.OP_OUTPUT:
            result.nz[made[1]] = work[taken[0]][0]
        else:
            values, known = zip(*(work[place] for place in taken), strict=True)
            if operation == ca.OP_DIV and known == (False, True):
                symbols.append(ca.SX.sym("reciprocal"))
                divisors.append(values[1])
                value = values[0] * symbols[-1]
            elif len(values) == 1:
                value = ca.SX.unary(operation, *values)
            else:
                value = ca.SX.binary(operation, *values)
            work[made[0]] = value, all(known)
    return result, ca.vertcat(ca.SX(0, 1), *symbols), ca.vertcat(ca.SX(0, 1), *divisors)


def _wrapper(name: str, function: ca.Function) -> str:
    """The function under its plain C signature."""
    arguments = function.name_in()
    found = () if name in _OF_UNKNOWNS else ("w", "w_by_v")
    given = [argument for argument in arguments if argument not in found]
    parts = {"w": _SOLVE, "w_by_v": _FOLLOW}
    return _WRAPPER.format(
        name=name,
        signature=", ".join(f"const double* {argument}" for argument in given) + ", double* result",
        prepare="".join(parts[argument] for argument in arguments if argument not in given),
        arguments=", ".join(arguments),
        result="result",
    )


def _sizes(system: HybridSystem, functions: dict[str, ca.Function]) -> str:
    """Sizes as macros, so that the runtime's arrays have fixed length."""
    sizes = {
        "N_STATES": system.x.numel(),
        "N_INPUTS": system.u.numel(),
        "N_GIVEN": sum(name not in POSITION_OF for name in system.interface.input_names),
        "N_PARAMETERS": system.p.numel(),
        "N_PREPARED": system.p.numel() + functions["prepare"].numel_out(0),
        "N_MODES": system.r.numel(),
        "N_INDICATORS": system.indicators.numel(),
        "N_OUTPUTS": system.outputs.numel(),
        "N_UNKNOWNS": system.w.numel(),
    } | {
        f"N_{name.upper()}": function.nnz_out(0)
        for name, function in functions.items()
        if name == "unknowns_by_v" or name.endswith("_jacobian")
    }
    return "".join(f"#define {name} {size}\n" for name, size in sizes.items())


def _tables(system: HybridSystem) -> str:
    """Start values and scales that the solver needs; of which input each input is the rate."""
    interface = system.interface
    inputs = interface.input_names
    positions = [POSITION_OF.get(name) for name in inputs]
    rows = {
        "state_nominal": (repr(state.nominal) for state in interface.states),
        "mode_start": (repr(mode.start) for mode in interface.modes),
        "output_at_motor": (repr(float(output.at_motor)) for output in interface.outputs),
    }
    tables = [
        f"static const double {name}[] = {{{_c_list(values)}}};\n" for name, values in rows.items()
    ]
    rate_of = _c_list(inputs.index(name) if name else -1 for name in positions)
    return "".join([*tables, f"static const int rate_of[] = {{{rate_of}}};\n"])


@one_at_a_time
def generate(system: HybridSystem) -> str:
    """C source of a structure.

    Parameters
    ----------
    system : HybridSystem

    Returns
    -------
    str, one C file that defines sizes, tables, patterns and the ``model_*`` functions
    """
    functions = _functions(system)
    generator = ca.CodeGenerator(
        "casadi.c", {"with_header": False, "casadi_int": "int", "main": False, "mex": False}
    )
    for function in functions.values():
        generator.add(function)
    # CasADi leaves its helpers external
    helper = "casadi_real casadi_"
    body = re.sub(f"^{helper}", f"static {helper}", generator.dump(), flags=re.MULTILINE)
    patterns = [
        _PATTERN.format(
            name=name,
            columns=_c_list(function.sparsity_out(0).colind()),
            rows=_c_list(function.sparsity_out(0).row()),
        )
        for name, function in functions.items()
        if name.endswith("_jacobian")
    ]
    return "\n".join(
        [
            f"/* effects: {', '.join(e.id for e in system.interface.effects) or 'none'} */",
            "#define CASADI_SYMBOL_EXPORT static",
            _sizes(system, functions),
            '#include "model.h"',
            body,
            _tables(system),
            *patterns,
            *(_wrapper(name, functions[name]) for name in functions if name in _OF_UNKNOWNS),
            '#include "implicit.h"',
            *(_wrapper(name, functions[name]) for name in functions if name not in _OF_UNKNOWNS),
        ]
    )
