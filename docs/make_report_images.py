"""Picture a report, wide and as on a phone: ``python docs/make_report_images.py REPORT.html``."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

IMAGES = Path(__file__).parent / "images"
BROWSER = "chromium"
SMALLEST_PX = 500  # a headless window is no narrower; a frame in it is

# Width and height of each picture in pixels.
PICTURES = {"report.png": (1280, 2400), "report-phone.png": (390, 2400)}


def picture(report: Path, image: Path, width_px: int, height_px: int) -> None:
    """Write what a browser of some size shows of a report."""
    with tempfile.TemporaryDirectory() as folder:
        frame = Path(folder) / "frame.html"
        style = f"width:{width_px}px;height:{height_px}px;border:0"
        source = report.absolute().as_uri()
        frame.write_text(f'<body style="margin:0"><iframe src="{source}" style="{style}"></iframe>')
        command = [
            BROWSER,
            *("--headless", "--no-sandbox", "--hide-scrollbars", "--virtual-time-budget=10000"),
            *("--disable-background-networking", f"--user-data-dir={folder}/profile"),
            f"--window-size={max(width_px, SMALLEST_PX)},{height_px}",
            f"--screenshot={image.absolute()}",
            frame.as_uri(),
        ]
        subprocess.run(command, check=True, capture_output=True)


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    for name, size in PICTURES.items():
        picture(Path(sys.argv[1]), IMAGES / name, *size)
