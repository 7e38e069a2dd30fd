"""Picture a report, wide and as on a phone: ``python docs/make_report_images.py REPORT.html``."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

IMAGES = Path(__file__).parent / "images"

# Width and height of each picture in pixels.
PICTURES = {"report.png": (1280, 2400), "report-phone.png": (390, 2400)}


def picture(report: Path) -> None:
    """Write what Chromium shows of a report, once its plots are drawn."""
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        for name, (width_px, height_px) in PICTURES.items():
            page = chromium.new_page(viewport={"width": width_px, "height": height_px})
            page.goto(report.absolute().as_uri())
            page.wait_for_function("document.documentElement.dataset.plots")
            page.screenshot(path=IMAGES / name)
        chromium.close()


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    picture(Path(sys.argv[1]))
