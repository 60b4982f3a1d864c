"""The tests run gentbeam through scripts/gentbeam_runs.py; CTest says which program by GENTBEAM."""

import sys
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
