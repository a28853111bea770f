"""Pictures of the beam in pixels."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from oblique_impact import History, Scenario, simulate
from oblique_impact.renders import Style, export, render
from oblique_impact.renders.style import BARE, LIGHT

from . import contacts
from .mechanics import paper
from .studies import blocks

SIZE = (640, 360)
_GAP, _CAPTION = 14, 30  # pixels


def film() -> Image.Image:
    """Six stills, each with the option that makes it."""
    smooth = paper("contact.friction=frictionless")
    tiles = [
        ("a still of a run", [paper()], Style(SIZE)),
        ("--theme dark", [paper()], Style(SIZE, "dark")),
        ("--theme print", [paper()], Style(SIZE, "print")),
        ("--bare", [paper()], Style(SIZE, **BARE)),
        ("--colour moment", [paper()], Style(SIZE, quantity="moment")),
        ("two runs", [paper(), smooth], Style(SIZE)),
    ]
    return sheet([(name, still(runs, style)) for name, runs, style in tiles])


def still(histories: list[History], style: Style, **options: object) -> Image.Image:
    """Return a still, at 0.3245 s if nothing else is said."""
    names = ["friction", "smooth"] if len(histories) > 1 else []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "still.png"
        render(histories, file, style, **({"time": 0.3245, "names": names} | options))
        with Image.open(file) as picture:
            return picture.convert("RGB")


def sheet(tiles: list[tuple[str, Image.Image]]) -> Image.Image:
    """Put pictures of one size in two columns, a line of text below each."""
    colours, (width, height) = LIGHT, tiles[0][1].size
    rows = (len(tiles) + 1) // 2
    whole = Image.new("RGB", (2 * width + _GAP, rows * (height + _CAPTION + _GAP) - _GAP), colours.background)
    draw = ImageDraw.Draw(whole)
    font = ImageFont.truetype(_mono(), 19)
    for place, (name, picture) in enumerate(tiles):
        left, top = (place % 2) * (width + _GAP), (place // 2) * (height + _CAPTION + _GAP)
        whole.paste(picture, (left, top))
        draw.rectangle((left, top, left + width - 1, top + height - 1), outline=colours.line)
        draw.text((left + 6, top + height + 5), name, fill=colours.dim, font=font)
    return whole


def _mono() -> str:
    """Return the file of Matplotlib's fixed-width font."""
    from matplotlib import font_manager

    return font_manager.findfont("DejaVu Sans Mono")


def slap(file: Path) -> None:
    """The film of the slap."""
    look = Style((640, 280), charts=False, inset=False, trace=False, ghosts=False, title="")
    render(contacts.slap(), file, look, seconds=7.0, fps=10)


def scenario() -> Image.Image:
    """The beam of the page at its largest force."""
    history = simulate(Scenario.from_toml(blocks("scenario.md", "toml")[0]))
    return still([history], Style((1280, 560)), time=float(history["lambda_n"].idxmax()))


def paraview() -> Image.Image:
    """Render an export in ParaView by the program of the page; needs `pvpython` and `xvfb-run`."""
    (program,) = (text for text in blocks("paraview.md", "python") if "paraview" in text)
    background = [int(LIGHT.background[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    with tempfile.TemporaryDirectory() as folder:
        file, state, picture = (Path(folder) / name for name in ("beam.pvd", "state.py", "beam.png"))
        export(paper(), file, every=50)
        ending = [
            "scene.AnimationTime = 0.3245",
            "ResetCamera(view)",
            "view.UseColorPaletteForBackground = 0",
            f"view.Background = {background}",
            f"SaveScreenshot({str(picture)!r}, view, ImageResolution=[1280, 720])",
        ]
        program = program.replace("out/beam", str(file.with_suffix("")))
        state.write_text("\n".join([program, *ending]), encoding="utf-8")
        plain = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        server = ["xvfb-run", "-a", "-s", "-screen 0 1400x900x24"]
        command = [*server, "pvpython", "--force-offscreen-rendering", str(state)]
        subprocess.run(command, check=True, env=plain, capture_output=True, timeout=300)
        with Image.open(picture) as drawn:
            return drawn.convert("RGB")
