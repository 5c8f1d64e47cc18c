#!/usr/bin/env python3
"""Runs that are killed at random times, again and again, end with the bits of one that never was. run.py CALOR [KILLS [SEED]]

Every kind of run takes its turn; KILLS in all (default 10). A run is stored every few steps, killed by SIGKILL (with -j 2 one of its
processes by turns with the command), and started again with --restart until it has come to its end."""
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

CALOR = str(pathlib.Path(sys.argv[1]).resolve())
KILLS = int(sys.argv[2]) if len(sys.argv) > 2 else 10
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 1
ROOT = pathlib.Path(__file__).resolve().parents[2]

PLATE = ["cases/start/plate.toml", "output.every=10 min"]
KINDS = {
    "euler": [*PLATE, "time.integrator=euler", "time.end=20 min", "output.every=1 min", "output.checkpoint_steps=5000"],
    "rkl2": [*PLATE, "time.integrator=rkl2", "cloud.points=[41,21]", "time.step=2 s"],
    "tr-bdf2": [*PLATE, "time.integrator=tr-bdf2", "time.step=5 s"],
    "crank-nicolson": [*PLATE, "time.integrator=crank-nicolson", "time.step=5 s"],
    "backward-euler": [*PLATE, "time.integrator=backward-euler", "time.step=5 s"],
    "mlpg": [*PLATE, "method=mlpg", "time.step=10 s"],
    "peridynamics": [*PLATE, "method=peridynamics", "cloud.points=[41,21]", "time.integrator=rkl2", "time.step=2 s"],
    "weld": ["cases/start/weld.toml", "cloud.spacing=4 mm"],
    "melting": ["cases/dan/melting.toml"],
    "opening crack": ["opening-crack.toml", "output.every=10 min", "time.integrator=tr-bdf2", "time.step=5 s"],
}
CRACK = '\n[[crack]]\nx = ["10 mm", "10 mm"]\ny = ["2 mm", "10 mm"]\nopens = "33 min"\n'
LONGEST = 60  # s, of one run


def command(words, folder, ranks, restart):
    stored = [] if any(word.startswith("output.checkpoint_steps") for word in words) else ["output.checkpoint_steps=100"]
    return [CALOR, "run", *words, *stored, "-o", str(folder), "--quiet", *(["-j", str(ranks)] if ranks > 1 else []),
            *(["--restart"] if restart else [])]


def children(parent):
    found = []
    for path in pathlib.Path("/proc").iterdir():
        if path.name.isdigit():
            try:
                if int((path / "stat").read_text().rpartition(")")[2].split()[1]) == parent:
                    found.append(int(path.name))
            except (OSError, IndexError):
                pass
    return found


def kill(run, ranks, one_alone):
    """The command, or the last of its ranks."""
    victim = run.pid
    if ranks > 1 and one_alone:
        of_launcher = [child for launcher in children(run.pid) for child in children(launcher)]
        victim = of_launcher[-1] if of_launcher else victim
    try:
        os.kill(victim, signal.SIGKILL)
    except ProcessLookupError:
        pass
    run.wait()


def bits(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and path.name not in ("run.log", "report.json")}


def main():
    chance = random.Random(SEED)
    done, failed = 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        here = pathlib.Path(temporary)
        (here / "opening-crack.toml").write_text((ROOT / "cases/start/plate.toml").read_text() + CRACK)
        turn = 0
        while done < KILLS:
            kind, (case, *changes) = list(KINDS.items())[turn % len(KINDS)]
            words = [str((ROOT if "/" in case else here) / case), *changes]
            ranks = 2 if turn % 3 == 2 else 1
            whole, parts = here / f"{turn}-whole", here / f"{turn}-parts"
            begin = time.monotonic()
            subprocess.run(command(words, whole, ranks, False), check=False, capture_output=True, timeout=LONGEST)
            lasts = time.monotonic() - begin
            kills = 0
            for attempt in range(8):
                has_checkpoint = any((parts / f"checkpoint-{slot}").exists() for slot in (0, 1))
                run = subprocess.Popen(command(words, parts, ranks, has_checkpoint), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                try:
                    if kills < 3 and done + kills < KILLS:
                        run.wait(lasts * chance.uniform(0.2, 0.8))
                    run.wait(LONGEST)
                except subprocess.TimeoutExpired:
                    kill(run, ranks, one_alone=kills % 2 == 0)
                    kills += 1
                    continue
                if run.returncode in (0, 1):
                    break
            here_bits, there_bits = bits(whole), bits(parts)
            differ = sorted(name for name in here_bits.keys() | there_bits.keys() if here_bits.get(name) != there_bits.get(name))
            done += kills
            failed += bool(differ) or run.returncode not in (0, 1)
            print(f"{'FAIL' if differ or run.returncode not in (0, 1) else 'ok  '}  {kind:<15} {ranks} process{'es' if ranks > 1 else '  '} {kills} kills of {lasts:.1f} s"
                  + (f": other bits in {', '.join(differ)}" if differ else "") + (f" code {run.returncode}: {run.stderr.read().decode()[:300]}" if run.returncode not in (0, 1) else ""), flush=True)
            turn += 1
            if turn > 4 * KILLS:
                break
    print(f"{done} kills, {failed} runs with other bits")
    sys.exit(failed > 0 or done == 0)


main()
