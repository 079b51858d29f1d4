"""Files that are written at once, or not at all."""

import os
import stat
import threading

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
