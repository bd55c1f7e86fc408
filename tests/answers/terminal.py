"""Run a command whose standard output is a terminal of ``COLUMNS`` columns, and pass on what it prints there."""

from __future__ import annotations

import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios


def main() -> int:
    """Run the command on the command line; return its exit code."""
    inside, outside = pty.openpty()
    size = struct.pack("HHHH", 50, int(os.environ["COLUMNS"]), 0, 0)
    fcntl.ioctl(outside, termios.TIOCSWINSZ, size)
    process = subprocess.Popen(sys.argv[1:], stdout=outside)
    os.close(outside)
    while True:
        try:
            piece = os.read(inside, 65536)
        except OSError:  # Linux says so where the other side is closed
            break
        if not piece:
            break
        sys.stdout.buffer.write(piece.replace(b"\r\n", b"\n"))
    return process.wait()


if __name__ == "__main__":
    sys.exit(main())
