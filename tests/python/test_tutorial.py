"""docs/tutorial.md and docs/faq.md, line by line: decks are saved, commands and programs run, and what they
print is compared with what the page says."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("GENTBEAM", ROOT / "build" / "release" / "gentbeam")).resolve()
BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```$", re.M | re.S)


def environment():
    found = dict(os.environ)
    found["PATH"] = f"{PROGRAM.parent}{os.pathsep}{found['PATH']}"
    found["PYTHONPATH"] = str(ROOT / "python")
    found["GENTBEAM_LIBRARY"] = str(PROGRAM.parent / "libgentbeam.so")
    return found


def run(kind, text, folder):
    if kind == "python":
        command = [sys.executable, "-c", text]
    else:
        command = ["bash", "-ec", text.replace("scripts/", f"{sys.executable} {ROOT}/scripts/")]
    return subprocess.run(command, cwd=folder, env=environment(), text=True, capture_output=True, check=False)


def missing_lines(wanted, said):
    """Lines of the page that are not the beginning of a line that was printed, in their order."""
    lines, missing = iter(said.splitlines()), []
    for line in wanted.splitlines():
        if not any(printed.startswith(line) for printed in lines):
            missing.append(line)
            lines = iter(said.splitlines())
    return missing


def test_tutorial(tmp_path):
    blocks = BLOCK.findall((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8"))
    assert len(blocks) > 25
    said, compared = "", 0
    for kind, name, text in blocks:
        if kind == "deck":
            (tmp_path / name).write_text(text)
        elif kind == "output":
            assert missing_lines(text, said) == [], f"{text}\nnot in\n{said}"
            compared += 1
        else:
            done = run(kind, text, tmp_path)
            said = done.stdout
            assert done.returncode == 0, f"{text}\n{done.stderr}"
    assert compared >= 9
    for picture in ("tip.png", "swing.gif", "swing.html"):
        assert (tmp_path / picture).stat().st_size > 1000


def faq_sections():
    text = (ROOT / "docs" / "faq.md").read_text(encoding="utf-8")
    for section in re.split(r"^## ", text, flags=re.M)[1:]:
        if "```" in section:
            yield pytest.param(section, id=re.sub(r"\W+", "-", section.splitlines()[0]).strip("-"))


@pytest.mark.parametrize("section", faq_sections())
def test_faq(section, tmp_path):
    """Every deck says what the page quotes; the commands that remedy it succeed and warn of nothing."""
    name, messages = None, 0
    for kind, argument, text in BLOCK.findall(section):
        if kind == "deck":
            name = argument
            (tmp_path / name).write_text(text)
        elif kind == "message":
            done = run("sh", f"gentbeam {name} 2>&1 || true", tmp_path)
            assert missing_lines(text, done.stdout) == [], done.stdout
            messages += 1
        else:
            for command in text.splitlines():
                done = run(kind, f"set -o pipefail; {command}", tmp_path)
                assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
                assert "warning" not in done.stdout, f"{command}\n{done.stdout}"
    assert messages > 0


def test_missing_lines_are_found():
    assert missing_lines("one\nthree\n", "one\ntwo\nthree and more\n") == []
    assert missing_lines("three\none\n", "one\ntwo\nthree\n") == ["one"]
    assert missing_lines("four\n", "one\n") == ["four"]
