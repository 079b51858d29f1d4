"""Files that are written at once, or not at all."""

import os
import signal
import stat
import tempfile
import threading

import pytest

from bladesmith.common.files import write_atomically


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_atomically(pipe, b"whole" * 100_000)  # more than a pipe holds
    reader.join(10)
    assert read == [b"whole" * 100_000] and stat.S_ISFIFO(pipe.stat().st_mode)
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


def test_an_interrupt_while_the_temporary_file_is_made_leaves_none(tmp_path, monkeypatch):
    make = tempfile.mkstemp

    def made_and_interrupted(*args, **named):
        found = make(*args, **named)
        os.kill(os.getpid(), signal.SIGINT)
        return found

    monkeypatch.setattr(tempfile, "mkstemp", made_and_interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "x", b"whole")
    assert not list(tmp_path.iterdir())
