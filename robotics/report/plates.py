"""The pictures of a page, drawn as PNG."""

import io
import warnings

from matplotlib.figure import Figure

from fuzzy.figures.drawing import style
from robotics.report.chapter import Picture, Plate

DPI = 200


def plate(picture: Picture | Plate) -> Plate:
    """Draw the picture, unless it is drawn already."""
    if isinstance(picture, Plate):
        return picture
    return Plate(picture.name, picture.caption, picture.alt, _png(picture.draw()))


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    with style(), warnings.catch_warnings():
        # A name that a user gave in letters which the font lacks is drawn with boxes; that is no error.
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
        # A level of 3 is a quarter quicker than the usual 6, for 4 % more bytes.
        figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None}, pil_kwargs={"compress_level": 3})
    return buffer.getvalue()
