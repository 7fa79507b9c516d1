"""The command line as a user meets it: help at once, sentences instead of tracebacks, exit codes."""

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from frontage.cli.main import COMMANDS, main


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def out(project: Path, pair_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the run, all of whose stages the command keeps."""
    folder = tmp_path_factory.mktemp("cli") / "out"
    shutil.copytree(pair_run, folder)
    result = call("run", project, "-o", folder, "--quiet")
    assert result.exit_code == 0, result.output
    assert result.output == ""
    return folder


def test_help_is_there_at_once_and_imports_nothing_heavy() -> None:
    code = (
        "import sys, time; t = time.process_time()\n"
        "from frontage.cli.main import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'cv2', 'pydantic', 'rich', 'scipy', 'laspy'} & set(sys.modules)\n"
        "print(time.process_time() - t, sorted(heavy), file=sys.stderr)"
    )
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(3)
    ]
    seconds = min(float(r.stderr.split()[0]) for r in runs)
    assert runs[0].stderr.split(maxsplit=1)[1].strip() == "[]"
    assert seconds < 0.2
    assert all(name in runs[0].stdout for name in COMMANDS)


def test_every_command_has_help() -> None:
    for name in COMMANDS:
        result = call(name, "--help")
        assert result.exit_code == 0 and "Usage:" in result.output, name


def test_wrong_usage_is_exit_code_2() -> None:
    for words in (
        ["fly"],
        ["run"],
        ["run", "--scan", "a.laz"],
        ["ortho"],
        ["pixel-to-world", "x", "B01/F1", "a", "1"],
    ):
        assert call(*words).exit_code == 2, words


def test_a_command_that_is_nearly_right_is_guessed() -> None:
    assert "No such command 'lcoate'. Did you mean 'locate'?" in call("lcoate").output
    assert "Did you mean" not in call("fly").output


def test_pixel_to_world_and_back(out: Path) -> None:
    there = call("pixel-to-world", out, "B01/F1", 40.5, 30.5, "--json")
    assert there.exit_code == 0
    point = json.loads(there.output)
    assert point["surface"] in ("relief", "plane") and point["crs"] == "EPSG:25832"
    back = json.loads(
        call("world-to-pixel", out, "B01/F1", point["x"], point["y"], point["z"], "--json").output
    )
    assert (back["column"], back["row"]) == pytest.approx((40.5, 30.5), abs=1e-6)
    words = call("pixel-to-world", out, "B01/F1", 40.5, 30.5).output.split()
    assert np.allclose([float(v) for v in words[:3]], [point["x"], point["y"], point["z"]], atol=1e-4)
    beyond = call("world-to-pixel", out, "B01/F1", point["x"] + 500, point["y"], point["z"])
    assert beyond.output.strip().endswith("outside")
    negative = call("world-to-pixel", out, "B01/F1", -5, -6, -7)
    assert negative.exit_code == 0  # numbers, not options


def test_json_is_the_only_thing_on_stdout(out: Path, project: Path) -> None:
    result = call("run", project, "-o", out, "--json")
    summary = json.loads(result.stdout)
    assert summary["items"]["ortho"] == len(summary["facades"]) > 0


def test_info_of_scan_cameras_and_run_folder(out: Path, project: Path) -> None:
    manifest = json.loads((out / "manifest.json").read_text())
    scans = [e["path"] for e in manifest["inputs"]["scans"] if e["path"].endswith(".laz")]
    cameras = manifest["project"]["photos"]["cameras"]
    *clouds, poses, folder = json.loads(call("info", *scans, cameras, out, "--json").output)
    assert len(clouds) == len(scans) == 2
    assert sum(cloud["points"] for cloud in clouds) == manifest["stages"]["scans"]["items"]
    assert len(poses["photos"]) == 2
    assert folder["stages"]["buildings"] == manifest["stages"]["buildings"]["items"]
    assert "EPSG:25832" in call("info", scans[0]).output


def test_stage_commands_work_on_a_run_folder(out: Path) -> None:
    for name, file in (("export", out / "model" / "facades.glb"), ("report", out / "report.html")):
        before = file.read_bytes()
        file.unlink()
        result = call(name, out, "--quiet")
        assert result.exit_code == 0, result.output
        assert file.read_bytes() == before


def test_the_method_of_openings_is_a_flag_of_run_and_of_its_stage(
    out: Path, project: Path, tmp_path: Path
) -> None:
    copy = Path(shutil.copytree(out, tmp_path / "copy"))
    made = json.loads(call("openings", copy, "--method", "paper", "--json").stdout)
    assert made["items"]["openings"] > 0 and any("method 'paper'" in note for note in made["notes"])
    assert json.loads((copy / "manifest.json").read_text())["project"]["openings"]["method"] == "paper"
    told = call("openings", copy, "--method", "evidence")
    assert told.exit_code == 0 and " openings in " in told.stdout
    again = json.loads(call("run", project, "--method", "paper", "-o", copy, "--json").stdout)
    assert again["items"] == made["items"]
    assert call("run", project, "--method", "guess", "-o", copy).exit_code == 2


def bad_inputs(tmp_path: Path, project: Path) -> dict[str, list[object]]:
    (tmp_path / "empty.laz").touch()
    (tmp_path / "noise.e57").write_bytes(b"no e57 at all" * 50)
    (tmp_path / "file").write_text("x")
    (tmp_path / "nan.xyz").write_text("nan nan nan\nnan nan nan\n")
    here = tmp_path / "out"
    return {
        "no such file": ["run", "--scan", tmp_path / "none.laz", "-o", here],
        "empty": ["run", "--scan", tmp_path / "empty.laz", "-o", here],
        "E57": ["run", "--scan", tmp_path / "noise.e57", "-o", here],
        "nan.xyz": ["run", "--scan", tmp_path / "nan.xyz", "-o", here],
        "is a file": ["run", project, "-o", tmp_path / "file"],
        "gsd": ["run", project, "--gsd", "-1", "-o", here],
        "EPSG:99": ["run", project, "--crs", "EPSG:99", "-o", here],
        "not a run folder": ["ortho", tmp_path],
        "give a PROJECT.toml": ["run", tmp_path / "none.toml", "-o", here],
    }


@pytest.mark.parametrize(
    "what",
    [
        "no such file",
        "empty",
        "E57",
        "nan.xyz",
        "is a file",
        "gsd",
        "EPSG:99",
        "not a run folder",
        "give a PROJECT.toml",
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_1(what: str, project: Path, tmp_path: Path) -> None:
    result = call(*bad_inputs(tmp_path, project)[what])
    assert result.exit_code == 1
    assert what in result.stderr and "bug" not in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert "Traceback" not in result.output


def test_a_bug_is_one_sentence_and_a_traceback_with_v(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import frontage.pipeline.run as module

    def broken(*_: object, **__: object) -> None:
        raise KeyError("secret")

    monkeypatch.setattr(module, "run_stage", broken)
    plain, verbose = call("report", out), call("report", out, "-v")
    assert (plain.exit_code, verbose.exit_code) == (1, 1)
    assert "a bug" in plain.stderr and "Traceback" not in plain.stderr
    assert "Traceback" in verbose.stderr


def _interruptible() -> None:
    """What a shell starts in the background ignores Ctrl-C, and its children with it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_ctrl_c_leaves_a_run_that_goes_on(project: Path, tmp_path: Path) -> None:
    words = [
        sys.executable,
        "-m",
        "frontage.cli.main",
        "run",
        str(project),
        "-o",
        str(tmp_path / "o"),
        "-w",
        "2",
        "-q",
    ]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, preexec_fn=_interruptible)
    marker = tmp_path / "o" / ".done" / "scans.json"
    deadline = time.monotonic() + 60
    while not marker.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert errors.strip() == "interrupted; the same command goes on where it was"
    result = call("run", project, "-o", tmp_path / "o", "--json")
    assert result.exit_code == 0 and json.loads(result.stdout)["facades"]
