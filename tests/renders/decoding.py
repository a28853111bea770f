"""Frames of films, as a player would find them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray


def decode(file: Path) -> tuple[float, NDArray[np.uint8]]:
    """Return the duration of a film (s) as the container tells it, and its frames (count, height, width, 3)."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    command = [ffmpeg, "-i", str(file), "-f", "rawvideo", "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    text = done.stderr.decode()
    width, height = map(int, re.search(r" (\d{2,})x(\d{2,})[ ,]", text).groups())
    hours, minutes, seconds = re.search(r"Duration: (\d+):(\d+):([\d.]+)", text).groups()
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds), frames
