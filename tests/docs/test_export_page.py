"""The page on exports, followed word by word."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app

PAGE = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_every_step_of_the_page_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("onnxruntime")
    monkeypatch.chdir(tmp_path)
    exports, build = blocks("sh")
    for line in exports.splitlines():
        done = CliRunner().invoke(app, line.split()[1:])
        assert done.exit_code == 0, done.output
    (snippet,) = blocks("python")
    exec(compile(snippet, "export.md", "exec"), {})
    assert float(capsys.readouterr().out) < 1e-5

    (own,) = blocks("c")
    Path("there/c/decide.c").write_text(own)
    build += "cc -std=c99 -Wall -Wextra -Werror -pedantic -c decide.c\n"
    subprocess.run(["sh", "-e", "-c", build], check=True, capture_output=True)
