"""The manual page and the completion for bash, which the program writes from its own tables."""

import re
import shutil
import subprocess

import pytest
from conftest import INPUT


@pytest.fixture
def page(gentbeam):
    return gentbeam("--man").out


def test_page_is_sound(page):
    """mandoc, a strict reader of manual pages, finds nothing but the date that is left out on purpose."""
    if not shutil.which("mandoc"):
        pytest.skip("no mandoc (scripts/test installs it on Debian)")
    command = ["mandoc", "-T", "lint", "-W", "warning"]
    said = subprocess.run(command, input=page, text=True, capture_output=True, check=False).stdout
    assert [line for line in said.splitlines() if "missing date" not in line] == []
    read = subprocess.run(
        ["mandoc", "-T", "ascii"], input=page, text=True, capture_output=True, check=True
    ).stdout
    text = re.sub(r".\x08", "", read)
    assert text.startswith("GENTBEAM(1)") and "gentbeam - large, fast motions of soft beams" in text
    assert "-o, --output NAME" in text


def test_page_has_every_option_command_and_key(gentbeam, page):
    plain = page.replace("\\-", "-").replace("\\&", "").replace("\\(dq", '"')
    options = re.findall(r"^  (?:-\w, )?(--[\w-]+)", gentbeam("--help").out, re.M)
    assert len(options) >= 12
    assert [option for option in options if f"\\fB{option}\\fR" not in plain] == []
    command = None
    found = 0
    for line in gentbeam("--keywords").out.splitlines()[2:]:
        if line and not line.startswith(" "):
            command = line
            assert f'.SS "{command}"' in plain
        elif re.match(r"    [a-z]\S*  ", line) and not line.startswith("     "):
            section = plain.split(f'.SS "{command}"\n')[1].split(".SS")[0]
            assert f".B {line.split()[0]}\n" in section, line
            found += 1
    assert found > 60


def test_help_knows_every_option_that_is_read(gentbeam):
    """An option with a letter missing is answered with that option."""
    for option in re.findall(r"^  (?:-\w, )?(--[\w-]+)", gentbeam("--help").out, re.M):
        gentbeam(option[:-1], status=1)
        assert f"did you mean '{option}'?" in gentbeam.err, gentbeam.err


@pytest.fixture
def complete(gentbeam):
    script = gentbeam.folder / "completion.bash"
    script.write_text(gentbeam("--completion").out)

    def run(*words):
        line = " ".join(f"'{word}'" for word in ("gentbeam", *words))
        ask = f"source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words)}; _gentbeam"
        ask += "; echo ${COMPREPLY[@]}"
        done = subprocess.run(["bash", "-c", ask], cwd=INPUT, text=True, capture_output=True, check=True)
        return done.stdout.split()

    return run


def test_completion(complete):
    assert complete("--ver") == ["--verbose", "--version"]
    assert complete("cantil") == ["cantilever.inp"]
    assert complete("cantilever.inp", "--set", "") == ["L=", "h=", "E=", "nu=", "jm="]
    assert complete("cantilever.inp", "--set", "j") == ["jm="]
    assert complete("--set", "") == []
    assert complete("--threads", "") == []
    assert "cantilever.inp" in complete("-o", "cant")
