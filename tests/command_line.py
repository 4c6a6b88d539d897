"""What tests of the command line share."""

MODEL = "biorob_x4_joint_3"
RATE = 200  # Hz, of short recordings


def only_line(result) -> str:
    """The one line on stderr; there must be no other and nothing on stdout."""
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    return line
