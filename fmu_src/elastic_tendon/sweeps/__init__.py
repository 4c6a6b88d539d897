"""Many runs: `elastic_tendon.sweep` does all of a task, on all cores or a cluster, into one table.

Tasks are made by `simulations.simulations` (at the points of `points.points`, whose factors come
from `factors.parse_factor`), `bootstrap.bootstrap` (refits) and `fleet.fleet` (diagnoses of many
robots); a task of one's own has the members of `task.Task`. `results.read_results` and
`summary.summarise` read what came of it.
"""

# here, and not beside the refits, so that the command line has it without numpy: with as many, a
# further refit lies beyond either end of their range with 2.5 %
FEWEST_REFITS = 39
WAIT = 600.0  # s for a worker of a cluster
