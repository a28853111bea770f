"""The scripts of the page of a run in Node, with a canvas that takes notes (`stage.js`)."""

from __future__ import annotations

import atexit
import json
import shutil
import subprocess
from functools import cache
from pathlib import Path

from oblique_impact.renders import player
from oblique_impact.renders.player.document import DRAWING
from oblique_impact.renders.player.packing import unpacked
from oblique_impact.renders.player.payload import payload
from tests.renders.page_arrays import frame_axes

NODE = shutil.which("node") or shutil.which("nodejs")
PAGE = Path(next(iter(player.__path__))) / "page"

#: answers each line, a source with what is given to it, with what its function returns
_SERVER = """
require("readline").createInterface({ input: process.stdin }).on("line", (line) => {
  const { source, given } = JSON.parse(line);
  let answer;
  try { answer = { value: new Function("given", source)(given) }; }
  catch (error) { answer = { error: String(error.stack) }; }
  process.stdout.write(`${JSON.stringify(answer)}\\n`);
});"""


@cache
def _node() -> subprocess.Popen[str]:
    node = subprocess.Popen([NODE, "-e", _SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(node.kill)
    return node


class Scripts:
    """The scripts of the page of a story."""

    def __init__(self, story):
        content = payload(story, 400)
        self.arrays, self.facts = {n: unpacked(entry) for n, entry in content.arrays.items()}, content.facts
        self.x, self.y = frame_axes(self.arrays, self.facts)
        self._content = {"arrays": json.dumps(content.arrays), "facts": json.dumps(content.facts)}
        files = [Path(__file__).with_name("stage.js"), *(PAGE / f"{name}.js" for name in DRAWING)]
        own = [file.read_text(encoding="utf-8") for file in files]
        self._source = "\n".join([*own, "readColours(); setScene(facts.factor);"])

    def value(self, expression, **given):
        """Value of a JavaScript expression, which may use what the scripts define, and CONTENT.NAME of `given`."""
        source, content = f"{self._source}\nreturn JSON.stringify({expression});", self._content | given
        node = _node()
        node.stdin.write(json.dumps({"source": source, "given": json.dumps(content)}) + "\n")
        node.stdin.flush()
        answer = json.loads(node.stdout.readline())
        assert "error" not in answer, answer["error"][:2000]
        return json.loads(answer["value"])

    def at(self, place, expression):
        """Value of an expression in which `moment` is what there is at a place among the frames."""
        return self.value(f"((moment) => {expression})(momentAt({place}, newMoment()))")

    def drawn(self, place, call):
        """What a call draws at a place among the frames."""
        return self.at(place, f"note(() => {call})")
