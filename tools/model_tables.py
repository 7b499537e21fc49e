#!/usr/bin/python3
"""model_tables.py [--check]: writes the computed tables of MODEL.md anew, or says which of them is no longer true.

Uses build/release/bin/servohil (SERVOHIL_BUILD: another build tree). Exit 1: --check found a difference.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = Path(os.environ.get("SERVOHIL_BUILD", ROOT / "build" / "release")) / "bin" / "servohil"
AIR_PERCENT = (0, 0.25, 0.5, 0.75, 1, 1.5, 2)


def servohil(*arguments):
    return subprocess.run([str(PROGRAM), *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def air_table():
    """The oscillating poles at x3 = 4 in over the air in an oil of 230,000 psi."""
    pairs = []
    for percent in AIR_PERCENT:
        out = json.loads(servohil("linear", "--x3", "4", "--json", "--set", "servo.bulk_modulus_psi=230000",
                                  "--set", f"oil.air_fraction={percent / 100}"))
        pairs.append(next(p for p in out["poles"] if p["imaginary_1_s"] > 0))
    head = " | ".join(f"{p:g} %" if p else "0" for p in AIR_PERCENT)
    real = " | ".join(f"{p['real_1_s']:+.1f}".replace("-", "−") for p in pairs)
    hertz = " | ".join(f"{p['frequency_hz']:.0f}" for p in pairs)
    return (f"| air R | {head} |\n|{'---|' * (len(pairs) + 1)}\n"
            f"| real part of the oscillating poles, 1/s | {real} |\n| frequency, Hz | {hertz} |\n")


def replaced(text, name, new):
    """The text with what stands between <!-- name --> and <!-- end --> replaced."""
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"MODEL.md: there is no <!-- {name} --> ... <!-- end -->")
    return pattern.sub(lambda m: m[1] + new + m[2], text)


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    document = ROOT / "MODEL.md"
    text = document.read_text()
    for name, table in (("air", air_table()), ("thesis", servohil("thesis", "--markdown"))):
        new = replaced(text, name, table)
        if new != text:
            print(f"MODEL.md: table '{name}' {'is not what the program gives' if sys.argv[1:] else 'written'}")
            if sys.argv[1:]:
                sys.exit(1)
        text = new
    if not sys.argv[1:]:
        document.write_text(text)


if __name__ == "__main__":
    main()
