"""Whether work is under way, so that buttons which would begin more wait until it is done."""

from dash import ClientsideFunction, Dash, Input, Output, State, dcc

WORDS = "Something is being computed; wait until it is done, or cancel it below."


def store(step_id: str) -> dcc.Store:
    """Where a step is reported; ``f"{step_id}-busy"``, whose `data` changes only when that does."""
    return dcc.Store(id=f"{step_id}-busy", data=False)


def register(app: Dash, step_id: str) -> None:
    """Let a step's `store` follow the work that the page shows, see assets/busy.js."""
    app.clientside_callback(
        ClientsideFunction("elastic_tendon_busy", "follow"),
        Output(f"{step_id}-busy", "data"),
        Input("work", "hidden"),
        State(f"{step_id}-busy", "data"),
    )
