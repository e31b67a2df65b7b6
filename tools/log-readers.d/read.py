"""Reads run logs with packages that are not ours, and says what it compared. Usage: read.py LOG..."""

import sys
from pathlib import Path

import container
import frames
import signals
from log_file import LogFile


def main() -> None:
    for path in map(Path, sys.argv[1:]):
        log = LogFile(path)
        print(f"{path.name}: {log.metadata['uarm.end']['end']}")
        for check in (container.check, signals.check, frames.check):
            print(f"  {check(log)}")
    print(f"{len(sys.argv) - 1} logs read")


if __name__ == "__main__":
    main()
