"""What no user means to give: one sentence each, exit code 1, nothing half-written."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from frontage.cli.main import main
from frontage.errors import printable


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def project(folder: Path, text: str | bytes) -> Path:
    path = folder / "project.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[scans]]\npath = "a\\u0000b.las"\n', "cannot be a path"),
        (f'[[scans]]\npath = "{"a" * 300}.las"\n', "cannot be a path (file name too long)"),
        ('[[scans]]\npath = "~nobody-of-this-name/x.las"\n', "cannot be a path"),
        ('[[scans]]\npath = "/"\n', "holds no COLMAP model"),
        ("a = " + "[" * 50_000 + "]" * 50_000, "nested too deeply"),
        (b"\xff\xfe\x00", "cannot be read as text"),
        (b"", "no scan is given"),
    ],
)
def test_projects_that_cannot_be_meant(tmp_path: Path, text: str | bytes, words: str) -> None:
    out = tmp_path / "out"
    result = call("run", project(tmp_path, text), "-o", out)
    assert result.exit_code == 1
    assert words in result.stderr and len(result.stderr.splitlines()) == 1
    assert "a bug" not in result.stderr and not out.exists()


def test_a_byte_order_mark_is_no_part_of_the_project(tmp_path: Path) -> None:
    result = call(
        "run", project(tmp_path, b'\xef\xbb\xbf[[scans]]\npath = "none.las"\n'), "-o", tmp_path / "o"
    )
    assert "none.las: no such file" in result.stderr


def test_absurd_numbers_of_workers_are_wrong_usage(tmp_path: Path) -> None:
    result = call("run", "--scan", "x.las", "-o", tmp_path, "--workers", 10**6)
    assert result.exit_code == 2 and "not in the range" in result.stderr


def test_names_cannot_command_the_terminal(tmp_path: Path) -> None:
    result = call("run", "--scan", "\x1b[31mred\x07.las", "-o", tmp_path / "out")
    assert result.exit_code == 1
    assert "\x1b" not in result.stderr and "\x07" not in result.stderr
    assert "\\x1b[31mred\\x07.las" in result.stderr
    assert printable("Fenêtre 窓\n") == "Fenêtre 窓\n"


def test_ctrl_c_while_python_still_imports_exits_130() -> None:
    code = (
        "import sys\n"
        "class Interrupted:\n"
        "    def find_spec(self, name, *rest):\n"
        "        if name == 'click':\n"
        "            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupted())\n"
        "from frontage.cli.entry import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 130 and done.stderr == "interrupted\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_that_a_library_turns_into_its_own_error_is_one(number: signal.Signals) -> None:
    code = (
        "import signal, sys, click\n"
        "from frontage.cli.main import main\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background of a shell\n"
        "def writing(*words, **rest):\n"
        "    try:\n"
        f"        signal.raise_signal({int(number)})\n"
        "    except KeyboardInterrupt:\n"
        "        raise OSError('Failed to call write') from None\n"
        "click.Group.main = writing\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 130 and done.stderr.startswith("interrupted;")


def test_warnings_are_told_with_quiet_and_fail_with_strict(
    simulated_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil

    from frontage.model import Failed
    from frontage.pipeline.stages import openings

    copy = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    monkeypatch.setattr(openings, "find_openings", lambda *_: Failed("F401", "too few points", "scan again"))
    quiet = call("openings", copy, "--quiet")
    assert quiet.exit_code == 0 and "warning F401 B01/F1: too few points; scan again" in quiet.stderr
    assert call("openings", copy, "--quiet", "--strict").exit_code == 1
