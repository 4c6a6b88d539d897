"""The points of a sweep: which values the factors have in each run.

Run i has the same point however it is asked for: points come in blocks of fixed size, each from
its number and the seed, and none is kept for longer than it is used.
"""

import inspect
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from textwrap import shorten
from typing import Any, Literal, get_args

import numpy as np
from scipy.stats import qmc

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.errors import SweepError
from elastic_tendon.result import LONGEST
from elastic_tendon.sweeps.factors import Array, Factor, Values, parse_factor, stated_factors

Method = Literal["grid", "monte-carlo", "latin-hypercube", "sobol"]

MOST_RUNS = 10**9  # Sobol's sequence of 30 bits ends a little later
BLOCK = 4096  # points; a power of 2, by which Sobol's sequence stays balanced
LATIN_BLOCK = 65_536  # points of one Latin hypercube, which must be drawn as a whole
HALF_STEP = 2.0**-31  # of Sobol's sequence: the middle of a step is never 0, where Gaussians end
# scipy has renamed the keyword in 1.15
_RANDOM = "rng" if "rng" in inspect.signature(qmc.Sobol.__init__).parameters else "seed"


@dataclass(frozen=True, repr=False)
class Points:
    """Values of `factors` in `count` runs.

    `method`: "grid", all combinations of the factors' values, the last factor fastest;
    "monte-carlo", independent draws; "latin-hypercube", draws of which each factor's are spread
    evenly (beyond 65536 runs, those of every 65536 runs are); "sobol", scrambled Sobol points,
    evenly spread over all factors together, best for a power of 2. With Monte Carlo and Sobol
    a larger `count` goes on where a smaller one ended; a grid draws nothing and ignores `seed`.

    Raises
    ------
    SweepError
        where nothing varies, a factor stands twice, or the method cannot do what is asked for
    """

    factors: tuple[Factor, ...]
    method: Method
    count: int
    seed: int

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            methods = ", ".join(get_args(Method))
            raise SweepError(f"there is no method {self.method!r}; choose one of {methods}")
        _check_factors(self.factors)
        if self.method == "grid" and self.count != combinations(self.factors):
            raise SweepError(
                f"a grid of these values has {combinations(self.factors)} runs, not {self.count}; "
                "leave the number of runs out, or draw with another method"
            )
        if not 1 <= self.count <= MOST_RUNS:
            raise SweepError(f"{self.count} runs cannot be done; 1 to {MOST_RUNS} can")
        if self.seed < 0:
            raise SweepError(f"the seed {self.seed} is negative; choose 0 or more")

    def __repr__(self) -> str:
        paths = shorten(", ".join(factor.path for factor in self.factors), LONGEST)
        return f"{self.count} runs by {self.method}, in which {paths} vary"

    @property
    def identity(self) -> dict[str, str]:
        """All that the points depend on, exactly."""
        text = {
            "varied": "; ".join(
                f"{factor.path}: {factor.distribution!r}" for factor in self.factors
            ),
            "method": self.method,
        }
        if self.method in ("grid", "latin-hypercube"):  # others go on where a smaller one ended
            text["number of runs"] = str(self.count)
        return text if self.method == "grid" else text | {"seed": str(self.seed)}

    def rows(self, start: int, stop: int) -> Array:
        """Points of the runs `start` to `stop` - 1.

        Returns
        -------
        (stop - start, k) array; a column for each factor, in its own unit
        """
        if self.method == "grid":
            return self._grid(start, stop)
        shares = self._shares(start, stop)
        columns = [factor.distribution.at(shares[:, i]) for i, factor in enumerate(self.factors)]
        return np.stack(columns, axis=1)

    def _grid(self, start: int, stop: int) -> Array:
        values = [_listed(factor) for factor in self.factors]
        indices = np.unravel_index(np.arange(start, stop), [len(listed) for listed in values])
        columns = [np.array(listed)[index] for listed, index in zip(values, indices, strict=True)]
        return np.stack(columns, axis=1)

    def _shares(self, start: int, stop: int) -> Array:
        size = LATIN_BLOCK if self.method == "latin-hypercube" else BLOCK
        shares = np.empty((stop - start, len(self.factors)))
        for block in range(start // size, -(-stop // size)):
            first = block * size
            wanted = slice(max(start, first), min(stop, first + size))
            drawn = self._block(block)[wanted.start - first : wanted.stop - first]
            shares[wanted.start - start : wanted.stop - start] = drawn
        return shares

    def _block(self, block: int) -> Array:
        width = len(self.factors)
        if self.method == "monte-carlo":
            return _monte_carlo(self.seed, block, width)
        if self.method == "sobol":
            return _sobol(self.seed, block, width)
        size = min(LATIN_BLOCK, self.count - block * LATIN_BLOCK)
        return _latin_hypercube(self.seed, block, width, size)


def points(
    factors: Sequence[Factor], method: Method, count: int | None = None, seed: int = 0
) -> Points:
    """Points of a sweep; None for the number of runs of a grid, which follows from its values.

    Parameters
    ----------
    factors : what varies
    method : see `Points`
    count : number of runs, 1 to 10^9
    seed : 0 or more; another one draws other points

    Returns
    -------
    Points

    Raises
    ------
    SweepError
        as `Points`; also where a number of runs is needed and missing
    """
    chosen = tuple(factors)
    if count is None and method == "grid":
        count = combinations(chosen)
    if count is None:
        raise SweepError(f"how many runs shall {method} draw? give their number")
    return Points(chosen, method, count, seed)


def vary(
    model: Model,
    spreads: Mapping[str, str | None] | None = None,
    method: Method | None = None,
    *,
    runs: int | None = None,
    seed: int = 0,
) -> Points:
    """Say which parameters of a model vary in a sweep, and how.

    Parameters
    ----------
    model : Model
    spreads : dotted path -> ``"5%"``: Gaussian, one sigma is 5 % of the value; ``"LOW:HIGH"`` or
        ``"-5%:5%"``: uniform; ``"LOW:HIGH:COUNT"`` or ``"A,B,C"``: these values; None: Gaussian,
        by the uncertainty that the model states. Units are those of model.toml. Without it, all
        to which [uncertainty] of the model gives one
    method : "grid", "monte-carlo", "latin-hypercube" or "sobol", see `Points`; None: see
        `default_method`
    runs : how many, 1 to 10^9; a grid has as many as its values have combinations
    seed : 0 or more; another one draws other points

    Returns
    -------
    Points

    Raises
    ------
    SweepError
        for a number that the model does not have, a spread that is none of these, or a method that
        cannot do what is asked for
    """
    factors = [
        parse_factor(model, path if spread is None else f"{path}={spread}")
        for path, spread in (spreads or {}).items()
    ] or stated_factors(model)
    return points(factors, method or default_method(factors, runs), runs, seed)


def default_method(factors: Sequence[Factor], runs: int | None) -> Method:
    """A grid where every factor has values and no number of runs is given, else Monte Carlo."""
    listed = all(isinstance(factor.distribution, Values) for factor in factors)
    return "grid" if listed and runs is None else "monte-carlo"


def combinations(factors: Sequence[Factor]) -> int:
    """Number of runs of a grid.

    Raises
    ------
    SweepError
        where a factor has a distribution without values
    """
    return math.prod(len(_listed(factor)) for factor in factors)


def _listed(factor: Factor) -> tuple[float, ...]:
    if not isinstance(factor.distribution, Values):
        raise SweepError(
            f"{factor.path}: a grid needs values; write {factor.path}=LOW:HIGH:COUNT or "
            f"{factor.path}=A,B,C, or draw with another method"
        )
    return factor.distribution.values


def _check_factors(factors: tuple[Factor, ...]) -> None:
    if not factors:
        raise SweepError("nothing varies; say which parameters of the model shall")
    paths = [factor.path for factor in factors]
    twice = sorted({path for path in paths if paths.count(path) > 1})
    if twice:
        raise SweepError(f"{twice[0]}: varies twice; leave one of both out")


# ---- blocks of shares, (n, width) from 0 to 1 ------------------------------------------------


@lru_cache(maxsize=2)
def _monte_carlo(seed: int, block: int, width: int) -> Array:
    return np.random.default_rng([seed, block]).random((BLOCK, width))


@lru_cache(maxsize=2)
def _sobol(seed: int, block: int, width: int) -> Array:
    engine = qmc.Sobol(width, bits=30, **_random(seed))
    _jump(engine, block * BLOCK)
    return np.asarray(engine.random(BLOCK)) + HALF_STEP


def _jump(engine: qmc.Sobol, count: int) -> None:
    """Leave out the first `count` points, as `fast_forward` does, but not one by one.

    Each step of the sequence adds the direction number of one bit. Up to a point those of all bits
    of its Gray code are added, and from point 2^b - 1 to the next one it is that of bit b.
    """
    if not count:
        return
    gray = (count - 1) ^ ((count - 1) >> 1)
    for bit in range(gray.bit_length()):
        if gray >> bit & 1:
            engine.num_generated = 1 << bit
            engine.fast_forward(1)
    engine.num_generated = count


@lru_cache(maxsize=2)
def _latin_hypercube(seed: int, block: int, width: int, size: int) -> Array:
    return np.asarray(qmc.LatinHypercube(width, **_random([seed, block])).random(size))


def _random(seed: int | list[int]) -> dict[str, Any]:
    return {_RANDOM: np.random.default_rng(seed)}
