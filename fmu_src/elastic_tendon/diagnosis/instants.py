"""Scalar CasADi functions at many instants at once.

CasADi's virtual machine takes one instant after the other; here each of its instructions is one
NumPy operation over all of them, and what depends on the parameters alone is calculated once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from scipy.special import erf, erfinv

from elastic_tendon.comparison.residuals import Array

_OPERATIONS: Mapping[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: np.positive,
    ca.OP_NEG: np.negative,
    ca.OP_INV: np.reciprocal,
    ca.OP_SQ: np.square,
    ca.OP_SQRT: np.sqrt,
    ca.OP_EXP: np.exp,
    ca.OP_EXPM1: np.expm1,
    ca.OP_LOG: np.log,
    ca.OP_LOG1P: np.log1p,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_TAN: np.tan,
    ca.OP_ASIN: np.arcsin,
    ca.OP_ACOS: np.arccos,
    ca.OP_ATAN: np.arctan,
    ca.OP_SINH: np.sinh,
    ca.OP_COSH: np.cosh,
    ca.OP_TANH: np.tanh,
    ca.OP_ASINH: np.arcsinh,
    ca.OP_ACOSH: np.arccosh,
    ca.OP_ATANH: np.arctanh,
    ca.OP_FLOOR: np.floor,
    ca.OP_CEIL: np.ceil,
    ca.OP_FABS: np.abs,
    ca.OP_SIGN: np.sign,
    ca.OP_ERF: erf,
    ca.OP_ERFINV: erfinv,
    ca.OP_NOT: lambda x: 1.0 * (x == 0.0),
    ca.OP_TWICE: lambda x: x + x,
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_DIV: np.divide,
    ca.OP_POW: np.power,
    ca.OP_CONSTPOW: np.power,
    ca.OP_FMOD: np.fmod,
    ca.OP_REMAINDER: lambda x, y: x - y * np.rint(x / y),
    ca.OP_FMIN: np.fmin,
    ca.OP_FMAX: np.fmax,
    ca.OP_COPYSIGN: np.copysign,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_HYPOT: np.hypot,
    ca.OP_LT: lambda x, y: 1.0 * (x < y),
    ca.OP_LE: lambda x, y: 1.0 * (x <= y),
    ca.OP_EQ: lambda x, y: 1.0 * (x == y),
    ca.OP_NE: lambda x, y: 1.0 * (x != y),
    ca.OP_AND: lambda x, y: 1.0 * ((x != 0.0) & (y != 0.0)),
    ca.OP_OR: lambda x, y: 1.0 * ((x != 0.0) | (y != 0.0)),
    ca.OP_IF_ELSE_ZERO: lambda x, y: np.where(x != 0.0, y, 0.0),
}


@dataclass(frozen=True)
class _Instruction:
    """One of CasADi's: from which registers to which, or the number that it is."""

    operation: int
    result: Sequence[int]
    operands: Sequence[int]
    number: float


class AtInstants:
    """A function of scalars at many instants.

    Parameters
    ----------
    function : of symbols SX, dense, with one output of k numbers
    """

    def __init__(self, function: ca.Function) -> None:
        self._width = function.numel_out(0)
        self._registers = function.sz_w()
        self._instructions = [
            _Instruction(
                operation := function.instruction_id(index),
                function.instruction_output(index),
                function.instruction_input(index),
                function.instruction_constant(index) if operation == ca.OP_CONST else 0.0,
            )
            for index in range(function.n_instructions())
        ]

    def __call__(self, instants: int, *arguments: Array) -> Array:
        """The function's numbers at n instants, (n, k).

        Parameters
        ----------
        instants : n
        arguments : (n, m) arrays, or (m,) of what is the same at all instants
        """
        rows = [np.ascontiguousarray(argument.T) for argument in arguments]
        found = np.zeros((self._width, instants))
        registers: list[Any] = [0.0] * self._registers
        with np.errstate(all="ignore"):
            for step in self._instructions:
                if step.operation == ca.OP_OUTPUT:
                    found[step.result[1]] = registers[step.operands[0]]
                elif step.operation == ca.OP_INPUT:
                    argument, index = step.operands
                    registers[step.result[0]] = rows[argument][index]
                elif step.operation == ca.OP_CONST:
                    registers[step.result[0]] = step.number
                else:
                    operands = (registers[place] for place in step.operands)
                    registers[step.result[0]] = _OPERATIONS[step.operation](*operands)
        return found.T
