"""Films as files of video: MP4 by PyAV, whose wheel carries its encoder, and GIF by Pillow."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...extras import lacking
from ...recording.life import Life
from ..files import OutputError
from ..palettes import DEFAULT
from .clock import frames_of
from .raster import Painter

try:
    from PIL import Image
except ModuleNotFoundError as error:
    raise lacking(error) from None

# In this order: what every player shows first.  Options: of the encoder, for about equal quality.
_ENCODERS: dict[str, dict[str, str]] = {
    "libx264": {"crf": "25", "preset": "veryfast", "tune": "animation"}, "libopenh264": {},
    "libsvtav1": {"crf": "30", "preset": "8"}, "mpeg4": {"qscale": "3"},
}
_COLOURS = 128  # of a GIF
MOST_FRAMES = 20_000


def save_video(life: Life, path: str | os.PathLike, *, width: int, rate: int, speed: float = 1.0, palette: str = DEFAULT) -> None:
    """Write a video, as the ending of `path` says.

    Args: width: pixels; rate: frames a second; speed: simulated s per s of life.  Raises OutputError.
    """
    steps = frames_of(life, rate, speed)
    if len(steps) > MOST_FRAMES:
        raise OutputError(f"the video would have {len(steps)} frames, over {MOST_FRAMES}: give a higher --speed, or fewer --frames")
    painter = Painter(life, width, palette)
    save = _save_gif if Path(path).suffix.lower() == ".gif" else _save_mp4
    save(painter, _frames(painter, steps), path, rate)


def _frames(painter: Painter, steps: Any) -> Iterator[Image.Image]:
    from tqdm import tqdm

    last, image, shown = -1, None, sys.stderr.isatty()
    for step in tqdm(steps, desc="Filming", unit="frame", delay=2, leave=False, disable=not shown):
        if image is None or step != last:
            last, image = step, painter.draw(int(step))
        yield image


def _save_mp4(painter: Painter, frames: Iterator[Image.Image], path: str | os.PathLike, rate: int) -> None:
    try:
        import av
    except ModuleNotFoundError as error:
        raise lacking(error) from None
    encoder = next((name for name in _ENCODERS if name in av.codecs_available and _encodes(av, name)), None)
    if encoder is None:
        raise OutputError("this PyAV has no encoder for MP4: install its wheel (pip install av), or save .html or .gif")
    with av.open(os.fspath(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
        stream: Any = container.add_stream(encoder, rate=rate)
        stream.width, stream.height = painter.size
        stream.pix_fmt = "yuv420p"
        stream.options = _ENCODERS[encoder]
        for image in frames:
            container.mux(stream.encode(av.VideoFrame.from_image(image)))
        container.mux(stream.encode())


def _encodes(av: Any, name: str) -> bool:
    try:
        av.codec.Codec(name, "w")
    except ValueError:
        return False
    return True


def _save_gif(painter: Painter, frames: Iterator[Image.Image], path: str | os.PathLike, rate: int) -> None:
    first = next(frames)
    colours = _palette(painter)

    def reduced(image: Image.Image) -> Image.Image:
        return image.quantize(palette=colours, dither=Image.Dither.NONE)

    rest = (reduced(image) for image in frames)
    reduced(first).save(path, format="GIF", save_all=True, append_images=rest, duration=round(100 / rate) * 10, loop=0, optimize=False)


def _palette(painter: Painter) -> Image.Image:
    """The colours of some frames of the film, as one palette for all."""
    steps = range(0, painter.steps, max(1, painter.steps // 8))
    wide, high = painter.size
    sheet = Image.new("RGB", (wide, high * len(steps)))
    for k, step in enumerate(steps):
        sheet.paste(painter.draw(step), (0, k * high))
    return sheet.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT)
