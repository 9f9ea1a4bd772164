"""The pictures of a page, drawn once: as PNG for the folder beside it, and as WebP, which is smaller, for the page."""

import io
import warnings
from collections.abc import Callable, Iterable

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageChops

from fuzzy.figures.drawing import style
from robotics.show.report.chapter import Picture, Plate

SCREEN = 150  # pixels of the page for an inch of a figure
DPI = 2 * SCREEN  # sharp on dense screens too
_COLORS = (64, 256)  # of a palette: as few as will do
_WHITE = 253  # of 255: from here on a palette means white
_OFF = 3.0  # of 255: how far the palette may be off, root mean square over the picture


def plate(picture: Picture | Plate) -> Plate:
    """Draw the picture, unless it is drawn already."""
    if isinstance(picture, Plate):
        return picture
    drawn = _drawn(picture.draw())
    width, height = (round(side * SCREEN / DPI) for side in drawn.size)
    few = _quantized(drawn)
    png = _written(few, "png", compress_level=6)
    # Without loss; the next steps of method take twice as long for 2 % less.
    webp = _written(few.convert("RGB"), "webp", lossless=True, method=3, quality=30)
    narrow = picture.narrow and plate(picture._replace(draw=picture.narrow, narrow=None))
    return Plate(picture.name, picture.caption, picture.alt, png, webp, width, height, narrow)


def plates_of(pictures: Iterable[Picture | Plate], advance: Callable[[], None] = lambda: None) -> list[Plate]:
    """Draw pictures; ``advance`` is called after each."""
    plates = []
    for picture in pictures:
        plates.append(plate(picture))
        advance()
    return plates


def _drawn(figure: Figure) -> Image.Image:
    buffer = io.BytesIO()
    with style(), warnings.catch_warnings():
        # A name that a user gave in letters which the font lacks is drawn with boxes; that is no error.
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
        figure.savefig(buffer, format="png", dpi=DPI, pil_kwargs={"compress_level": 0})
    return Image.open(buffer).convert("RGB")


def _quantized(image: Image.Image) -> Image.Image:
    """The picture with a palette of few colours: lines and letters need no more, and are a fifth as large."""
    for colors in _COLORS:
        few = image.quantize(colors, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        histogram = np.array(ImageChops.difference(image, few.convert("RGB")).histogram()).reshape(3, 256)
        if np.sqrt((histogram * np.arange(256) ** 2).sum() / histogram.sum()) <= _OFF:
            break
    few.putpalette([255 if v >= _WHITE else v for v in few.getpalette() or []])
    return few


def _written(image: Image.Image, kind: str, **options: int | bool) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()
