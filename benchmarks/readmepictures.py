"""The pictures of README.md: what its snippets draw, and a film of the designer in a real browser.

``python -m benchmarks.readmepictures docs/start`` writes them there (two minutes); they are kept with the page.
"""

import io
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.designerpictures import _rest, _try_it, run
from benchmarks.designersession import browser, served, show, tab, workplace
from fuzzy.files.atomic import replacing

ROOT = Path(__file__).parent.parent
PICTURES = {  # by the name here: what a snippet draws
    "surface": "surface.png",
    "formation": "formation.png",
    "compared": "comparison/figures/lyapunov-sine-paths.png",
}
WIDTH, HEIGHT = 1400, 860  # px, of the page
SHOWN = 900  # px, of the film
FRAMES, HOLD = 36, 12  # frames that drag there and back, and frames at rest
EACH = 90  # ms a frame
REACH = 41  # px that are dragged: from 3 rad/s to near none
STILL = 22  # the frame that stands where films do not play


def drawn(folder: Path) -> list[Path]:
    """Run the README's snippets but ``make``, and keep their pictures in ``folder``."""
    from PIL import Image

    blocks = re.findall(r"```(\w+)\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    kept = []
    with tempfile.TemporaryDirectory() as place:
        for kind, text in blocks:
            if "make " not in text:
                program = [sys.executable, "-c", text] if kind == "python" else ["sh", "-e", "-c", text]
                subprocess.run(program, cwd=place, check=True, stdout=subprocess.DEVNULL)
        for name, file in PICTURES.items():
            picture = Image.open(Path(place) / file).convert("RGB")
            with replacing(folder / f"{name}.webp") as part:
                picture.save(part, format="WEBP", quality=88, method=6)
            kept.append(folder / f"{name}.webp")
    return kept


def film(folder: Path) -> list[Path]:
    """Drag a consequent there and back, and film it: how sharply the robot turns to its left."""
    from PIL import Image

    frames: list[Any] = []
    with tempfile.TemporaryDirectory() as place:
        workplace(Path(place))
        with served(Path(place), "tracking.fis") as (url, _), browser() as opened:
            page = opened.new_page(viewport={"width": WIDTH, "height": HEIGHT})
            show(page, url)
            _try_it(page)
            tab(page, "Memberships")
            page.locator(".fd-terms .fd-tab.fd-output").nth(1).click()
            _rest(page)
            page.evaluate("scrollTo(0, 0)")
            handle = page.get_by_role("slider", name="Positive: value", exact=True).bounding_box()
            x, y = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
            page.mouse.move(x, y)
            page.mouse.down()
            for k in range(FRAMES + HOLD):
                turn = min(k, FRAMES - k, FRAMES // 2) if k < FRAMES else 0
                page.mouse.move(x - REACH * turn / (FRAMES // 2), y)
                page.wait_for_timeout(350)  # for the runs of this place
                frames.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
            page.mouse.up()
    small = [frame.resize((SHOWN, SHOWN * HEIGHT // WIDTH), Image.Resampling.LANCZOS) for frame in frames]
    with replacing(folder / "film.webp") as part:
        small[0].save(
            part, format="WEBP", save_all=True, append_images=small[1:], duration=EACH, loop=0, quality=60, method=6
        )
    with replacing(folder / "film-still.webp") as part:
        small[STILL].save(part, format="WEBP", quality=85, method=6)
    return [folder / "film.webp", folder / "film-still.webp"]


def pictures(folder: Path) -> list[Path]:
    """The film and the pictures of the README, in ``folder``."""
    return [*film(folder), *drawn(folder)]


if __name__ == "__main__":
    run(pictures, __doc__, "docs/start")
