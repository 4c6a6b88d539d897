"""Names that users give, as figures show them."""

LONGEST = 44  # letters of a recording's name in a title
NARROW = 22  # letters of the path of a number in a table


def verbatim(name: str) -> str:
    """A name that matplotlib draws as it is: it takes what stands between dollars for formulas.

    Parameters
    ----------
    name : str; of a model, a recording, an effect or a parameter
    """
    return name.replace("$", r"\$")


def abridged(name: str) -> str:
    """The name of a recording, its middle left out where it would not fit into a title."""
    if len(name) > LONGEST:
        return f"{name[: LONGEST // 2]}…{name[-LONGEST // 2 + 1 :]}"
    return name


def at_dots(path: str) -> str:
    """The dotted path of a parameter for a narrow column: a long one goes on in further lines."""
    return path if len(path) <= NARROW else path.replace(".", ".\n")


def shortened(name: str) -> str:
    """The name of a recording for a title that matplotlib draws."""
    return verbatim(abridged(name))
