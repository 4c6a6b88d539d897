"""``python -m elastic_tendon``, where the command is not on the path."""

from elastic_tendon.cli import main

main()
