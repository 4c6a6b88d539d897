"""CasADi to C: the generated part of the library, behind the narrow waist `runtime/model.h`.

Every function is scalar-expanded (SX), works on caller's memory and needs libm only. The
Jacobians are taken with respect to the stacked vector v = [x; u; p] and stored as the nonzeros
of a compressed-column pattern, which the runtime multiplies with directions.
"""

import re
from collections.abc import Iterable

import casadi as ca

from elastic_tendon.model import HybridSystem

_PATTERN = """\
static const Pattern {name}_pattern = {{
  (const int[]){{{columns}}},
  (const int[]){{{rows}}}
}};
"""

_WRAPPER = """\
static inline void model_{name}({signature}) {{
  const double* arg[] = {{{arguments}}};
  double* res[] = {{{result}}};
  casadi_{name}(arg, res, 0, 0, 0);
}}
"""


def _c_list(values: Iterable[object]) -> str:
    """Initialiser of a C array, never empty (C99 has no empty arrays)."""
    return ", ".join(str(value) for value in values) or "0"


def _functions(system: HybridSystem) -> dict[str, ca.Function]:
    """CasADi functions by the name that the runtime calls, without their ``model_`` prefix."""
    x, u, p, r = system.x, system.u, system.p, system.r
    v = ca.vertcat(x, u, p)
    at, after = [x, u, p, r], [x, u, p, r, system.r_next]
    expressions = {
        "rates": (at, system.rates),
        "outputs": (at, system.outputs),
        "indicators": (at, system.indicators),
        "next_modes": (at, system.next_modes),
        "reset": (after, system.reset),
        "rates_by_state": (at, ca.densify(ca.jacobian(system.rates, x))),
        "rates_jacobian": (at, ca.jacobian(system.rates, v)),
        "outputs_jacobian": (at, ca.jacobian(system.outputs, v)),
        "indicators_jacobian": (at, ca.jacobian(system.indicators, v)),
        "reset_jacobian": (after, ca.jacobian(system.reset, v)),
    }
    return {
        name: ca.Function(f"casadi_{name}", arguments, [expression])
        for name, (arguments, expression) in expressions.items()
    }


def _wrapper(name: str, function: ca.Function) -> str:
    """The function under its plain C signature."""
    names = ["x", "u", "p", "r", "r_next"][: function.n_in()]
    return _WRAPPER.format(
        name=name,
        signature=", ".join(f"const double* {argument}" for argument in names) + ", double* result",
        arguments=", ".join(names),
        result="result",
    )


def _sizes(system: HybridSystem, functions: dict[str, ca.Function]) -> str:
    """Sizes as macros, so that the runtime's arrays have fixed length."""
    sizes = {
        "N_STATES": system.x.numel(),
        "N_INPUTS": system.u.numel(),
        "N_PARAMETERS": system.p.numel(),
        "N_MODES": system.r.numel(),
        "N_INDICATORS": system.indicators.numel(),
        "N_OUTPUTS": system.outputs.numel(),
    } | {
        f"N_{name.upper()}": function.nnz_out(0)
        for name, function in functions.items()
        if name.endswith("_jacobian")
    }
    return "".join(f"#define {name} {size}\n" for name, size in sizes.items())


def _tables(system: HybridSystem) -> str:
    """Start values and scales that the solver needs."""
    interface = system.interface
    rows = {
        "state_start": (repr(state.start) for state in interface.states),
        "state_nominal": (repr(state.nominal) for state in interface.states),
        "mode_start": (repr(mode.start) for mode in interface.modes),
    }
    return "".join(
        f"static const double {name}[] = {{{_c_list(values)}}};\n" for name, values in rows.items()
    )


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
            *(_wrapper(name, function) for name, function in functions.items()),
        ]
    )
