"""What a long sweep tells, and where there is no terminal."""

import time

from elastic_tendon.cli import pace as module
from elastic_tendon.cli.pace import Pace, pace


def test_speed_workers_and_time_left_are_told():
    now, shown = [0.0], []
    told = Pace(lambda text, share: shown.append((text, share)), clock=lambda: now[0])
    told.runs = 1000
    told("100 of 1000 runs, 0 failed", 0.1)  # done before, as nothing of it took time here
    told("100 of 1000 runs, 0 failed; 9 workers", 0.1)
    now[0] = 100.0
    told("200 of 1000 runs, 3 failed", 0.2)
    assert shown[-1] == ("200 of 1000 runs, 3 failed, 9 workers, 1 runs/s, 13 min left", 0.2)
    told("200 of 1000 runs, 3 failed; waiting for a worker, 3 of 600 s", 0.2)
    assert shown[-1][0].endswith("left, waiting for a worker, 3 of 600 s")


def test_lines_come_without_a_terminal_even_where_nothing_ends(monkeypatch, capsys):
    monkeypatch.setattr(module, "LINE_SECONDS", 0.05)
    with pace() as told:
        told.runs = 10
        told("3 of 10 runs, 1 failed", 0.3)
        told("3 of 10 runs, 1 failed; worker tcp://a:1 is left out: full disk", 0.3)
        time.sleep(0.5)
    lines = capsys.readouterr().err.splitlines()
    assert lines.count("elastic-tendon: worker tcp://a:1 is left out: full disk") == 1
    assert lines.count("3 of 10 runs, 1 failed") >= 2
