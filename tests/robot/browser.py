"""Pages in a headless Chromium: each in a frame as wide as a phone or a desk, looked at by a script.

One start of the browser looks at all pages. A frame of ``srcdoc`` has the width that media queries see, and
may be read by the page around it, which a file of its own may not.
"""

import html
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

PHONE_PX, DESK_PX = 390, 1100
NAMES = ("chromium", "chromium-browser", "google-chrome")
QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars",
)  # fmt: skip

# Runs first in each page: what a console would show.
LISTEN = """<script>
window.told = [];
addEventListener('error', e => told.push(e.message || 'not loaded: ' + e.target.src), true);
for (const kind of ['error', 'warn'])
  console[kind] = (...words) => told.push(kind + ': ' + words.join(' '));
</script>"""

PROBE = """
function scrolls(one) {
  for (let up = one.parentElement; up; up = up.parentElement)
    if (getComputedStyle(up).overflowX !== 'visible' && up.tagName !== 'HTML' && up.tagName !== 'BODY')
      return true;
  return false;
}
function overlaps(svg) {
  const boxes = [...svg.querySelectorAll('text')].filter(t => t.textContent.trim())
    .map(t => [t.textContent.trim(), t.getBoundingClientRect()]).filter(([, b]) => b.width > 0);
  const found = [];
  boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
    const w = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const h = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    const least = Math.min(p.width * p.height, q.width * q.height);
    if (w > 0 && h > 0 && w * h > SHARE * least) found.push(a + ' | ' + b);
  }));
  return found;
}
function lines(doc, cell) {
  const range = doc.createRange();
  range.selectNodeContents(cell);
  return new Set([...range.getClientRects()].map(box => Math.round(box.top))).size;
}
function look(frame) {
  const doc = frame.contentDocument, wide = frame.contentWindow.innerWidth;
  const own = [...doc.body.querySelectorAll('*')].filter(e => !e.closest('svg') || e.tagName === 'svg');
  const svgs = [...doc.querySelectorAll('svg')], imgs = [...doc.images];
  return {
    errors: frame.contentWindow.told,
    scroll: doc.documentElement.scrollWidth, width: wide,
    wide: own.filter(e => e.getBoundingClientRect().right > wide + 1 && !scrolls(e))
      .map(e => e.tagName + ' ' + e.className + ' ' + e.textContent.slice(0, 40)),
    pictures: svgs.length + imgs.length,
    empty: svgs.filter(s => s.getBBox().width < 10 || s.getBoundingClientRect().height < 10).length
      + imgs.filter(i => !(i.complete && i.naturalWidth > 0)).length,
    overlaps: svgs.flatMap(overlaps),
    broken: [...doc.querySelectorAll('td.pass, td.warn, td.fail, td.skip, td.short')]
      .filter(cell => lines(doc, cell) > 1).map(cell => cell.textContent),
    ink: getComputedStyle(doc.body).color, paper: getComputedStyle(doc.body).backgroundColor,
    text: doc.body.innerText.length,
  };
}
addEventListener('load', () => {
  const out = Object.fromEntries([...document.querySelectorAll('iframe')].map(f => [f.name, look(f)]));
  document.getElementById('out').textContent = JSON.stringify(out);
});
"""
OVERLAP_SHARE = 0.15


@dataclass(frozen=True, slots=True)
class Seen:
    """What a page looked like at a width.

    Attributes:
        errors: What a console would have shown.
        wide: Elements that stand out of the page on the right.
        scroll_px: Width that the page needs.
        width_px: Width that it has.
        pictures: Number of pictures.
        empty: Pictures that are not drawn.
        overlaps: Pairs of texts in a picture that lie on each other.
        broken: Verdicts, and numbers with their unit, that stand on two lines.
        ink: Colour of its text.
        paper: Colour behind it.
        letters: Number of letters shown.
    """

    errors: tuple[str, ...]
    wide: tuple[str, ...]
    scroll_px: int
    width_px: int
    pictures: int
    empty: int
    overlaps: tuple[str, ...]
    broken: tuple[str, ...]
    ink: str
    paper: str
    letters: int


def find_browser() -> str:
    """Return the path of a Chromium, empty if there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), "")


def look_at(
    pages: dict[str, str], folder: Path, width_px: int, *more: str
) -> dict[str, Seen]:  # fmt: skip
    """Look at pages in frames of one width.

    Args:
        pages: HTML by name.
        folder: Where pages may lie that load pictures from beside them; the browser's files go here too.
        width_px: Of the frames.
        more: Further switches of the browser.
    """
    frames = "\n".join(
        f"<iframe name='{name}' style='border:0;width:{width_px}px;height:3000px' "
        f'srcdoc="{html.escape(LISTEN + page)}"></iframe>'
        for name, page in pages.items()
    )
    script = PROBE.replace("SHARE", str(OVERLAP_SHARE))
    around = folder / f"around-{width_px}{len(more)}.html"
    around.write_text(
        f"<!doctype html><meta charset='utf-8'><body style='margin:0'><script id='out' "
        f"type='application/json'></script><script>{script}</script>{frames}</body>",
        encoding="utf-8",
    )
    dom = run_browser(folder, "--virtual-time-budget=10000", "--dump-dom", *more, around.as_uri())
    (told,) = re.findall(
        r"<script id=\"out\" type=\"application/json\">(.*?)</script>", dom, re.DOTALL
    )
    return {name: _seen(one) for name, one in json.loads(told).items()}


def _seen(one: dict[str, object]) -> Seen:
    def words(key: str) -> tuple[str, ...]:
        listed = one[key]
        assert isinstance(listed, list)
        return tuple(map(str, listed))

    def number(key: str) -> int:
        value = one[key]
        assert isinstance(value, int)
        return value

    return Seen(words("errors"), words("wide"), number("scroll"), number("width"), number("pictures"),
                number("empty"), words("overlaps"), words("broken"), str(one["ink"]), str(one["paper"]),
                number("text"))  # fmt: skip


def without_scripts(page: str) -> str:
    """A page as a reader without scripts has it."""
    return re.sub("<script.*?</script>", "", page, flags=re.DOTALL)


def run_browser(folder: Path, *words: str) -> str:
    """Run the browser with a profile of its own; return what it printed."""
    command = [find_browser(), *QUIET, f"--user-data-dir={folder / 'profile'}", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    return done.stdout
