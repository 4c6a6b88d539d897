"""From equations to a loaded library: generated C, one compiler, one cache.

In comes a `HybridSystem`; out goes a shared library, for this machine in the cache (`library`) or
for any platform in an FMU (`binary`). `codegen` writes the model's C, `layout` the table of its
variables, `shared` what C and Python both know; `runtime/` holds solver, events, sensitivities and
the FMI functions: no physics.
"""
