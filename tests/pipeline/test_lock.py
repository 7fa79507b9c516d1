"""Two runs on one folder: the second is refused; a lock that a dead process left is taken over."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from frontage.errors import WorkspaceError
from frontage.pipeline.store.lock import NAME, _owner, locked


def test_the_second_run_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with locked(tmp_path):
        refused = pytest.raises(WorkspaceError, match=f"in use by another run .process {os.getpid()} on")
        with refused as told, locked(tmp_path):
            raise AssertionError("two runs hold the lock")
        assert "\n" not in str(told.value)
    assert not (tmp_path / NAME).exists()
    with locked(tmp_path):
        pass


def test_a_lock_of_a_process_that_has_ended_is_taken_over(tmp_path: Path) -> None:
    ended = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True)
    holder = {**_owner(), "pid": int(ended.stdout)}
    (tmp_path / NAME).write_text(json.dumps(holder))
    with locked(tmp_path):
        assert json.loads((tmp_path / NAME).read_text())["pid"] == os.getpid()


def test_a_number_that_another_process_got_since_is_no_holder(tmp_path: Path) -> None:
    if _owner()["started"] is None:
        pytest.skip("this system does not tell when processes started")
    (tmp_path / NAME).write_text(json.dumps({**_owner(), "started": "1"}))
    with locked(tmp_path):
        assert json.loads((tmp_path / NAME).read_text()) == _owner()


def test_a_lock_from_before_a_restart_is_stale(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(json.dumps({**_owner(), "boot": "another"}))
    with locked(tmp_path):
        assert json.loads((tmp_path / NAME).read_text()) == _owner()


def test_a_lock_of_another_host_is_believed_and_its_file_named(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(json.dumps({**_owner(), "host": "elsewhere"}))
    with pytest.raises(WorkspaceError, match=rf"on elsewhere.*remove .*{NAME}"), locked(tmp_path):
        raise AssertionError("the lock was ignored")


def test_a_torn_lock_does_not_block_for_ever(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text('{"pid"')
    os.utime(tmp_path / NAME, (1.0, 1.0))
    with locked(tmp_path):
        assert json.loads((tmp_path / NAME).read_text()) == _owner()
